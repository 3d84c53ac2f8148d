// A scene and its frames as JSON.

#include "client/app/report/json.hpp"

#include <algorithm>
#include <set>
#include <string_view>

#include "client/app/options/values.hpp"

namespace collided::cli {

namespace {

/// The name of an enum's value without its prefix.
std::string lower_case(const std::string& value, std::string_view prefix) {
  std::string name = value.substr(prefix.size());
  std::transform(name.begin(), name.end(), name.begin(), [](char c) { return c == '_' ? c : char(c - 'A' + 'a'); });
  return name;
}

std::string contact_count_name(v1::ContactKind kind) { return "contacts_" + long_name_of(kind); }

}  // namespace

std::string json_text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string json_lines(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

Json part_devices_json(const v1::SceneSpec& spec) {
  Json out = Json::array();
  for (const std::string& id : spec.part_devices()) out.push_back(id);
  return out;
}

namespace {

/// Of the meshes that are thicker than the scene's thickness, by name.
Json half_thickness_json(const v1::SceneSpec& spec) {
  Json out = Json::object();
  for (const v1::MeshSpec& mesh : spec.meshes())
    if (mesh.half_thickness() > 0) out[mesh.name()] = mesh.half_thickness();
  return out;
}

/// Names of the meshes that are solids.
Json solids_json(const v1::SceneSpec& spec) {
  Json out = Json::array();
  for (const v1::MeshSpec& mesh : spec.meshes())
    if (mesh.solid()) out.push_back(mesh.name());
  return out;
}

}  // namespace

Json scene_json(const v1::Scene& scene) {
  const v1::SceneSpec& spec = scene.spec();
  Json out = {{"vertices", scene.vertex_count()},    {"edges", scene.edge_count()},
              {"triangles", scene.triangle_count()}, {"meshes", spec.meshes_size()},
              {"backend", name_of(spec.backend())},  {"device", scene.device()}};
  for (const auto& [name, value] : described(spec)) std::visit([&](const auto& known) { out[name] = known; }, value);
  if (Json halves = half_thickness_json(spec); !halves.empty()) out["half_thickness"] = std::move(halves);
  if (Json solids = solids_json(spec); !solids.empty()) out["solids"] = std::move(solids);
  if (spec.part_devices_size() > 0) out["part_devices"] = part_devices_json(spec);
  return out;
}

Json stages_json(const v1::FrameMetrics& metrics) {
  Json out = Json::object();
  for (const v1::StageTime& stage : metrics.stages())
    out[stage.stage()] = out.value(stage.stage(), 0.0) + stage.milliseconds();
  return out;
}

// Every count, under the name that the protocol gives it.
Json counts_json(const v1::FrameCounts& counts) {
  using google::protobuf::FieldDescriptor;
  const auto& type = *v1::FrameCounts::descriptor();
  const auto& values = *v1::FrameCounts::GetReflection();
  Json out = Json::object();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor* field = type.field(i);
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_UINT32)
      out[field->name()] = values.GetUInt32(counts, field);
    else
      out[field->name()] = values.GetUInt64(counts, field);
  }
  return out;
}

// In the order of the scene's devices.
Json parts_json(const v1::FrameMetrics& metrics) {
  Json out = Json::array();
  for (const v1::PartMetrics& part : metrics.parts())
    out.push_back({{"share", part.share()},
                   {"step_ms", part.step_milliseconds()},
                   {"pair_count", part.pairs()},
                   {"contact_count", part.contacts()}});
  return out;
}

Json frame_json(const v1::FrameDone& done, v1::Report report) {
  const v1::FrameMetrics& m = done.metrics();
  Json out = {{"total_ms", m.total_milliseconds()},
              {"queue_ms", m.queue_milliseconds()},
              {"step_ms", m.step_milliseconds()},
              {"stage_ms", stages_json(m)},
              {"engine", name_of(m.broad_phase_engine())},
              {"list_use", name_of(m.list_use())},
              {"list_frames", m.list_frames()},
              {"list_margin", m.list_margin()},
              {"counts", counts_json(m.counts())},
              {"replays", m.replays()},
              {"allocations", m.allocations()},
              {"graph_launches", m.graph_launches()},
              {"device_bytes", m.device_bytes()},
              {"bytes_in", m.bytes_in()},
              {"bytes_out", m.bytes_out()},
              {"warnings", warnings_json({m})}};
  if (m.parts_size() > 0) out["parts"] = parts_json(m);
  if (report == v1::REPORT_ANY_HIT) clear_contact_counts(out["counts"]);
  return out;
}

std::string long_name_of(v1::ContactKind kind) { return lower_case(v1::ContactKind_Name(kind), "CONTACT_KIND_"); }

std::string long_name_of(v1::ContactField field) { return lower_case(v1::ContactField_Name(field), "CONTACT_FIELD_"); }

Json contact_counts_json(const client::PerKind<uint64_t>& counts) {
  Json out = Json::object();
  for_each_kind([&](v1::ContactKind kind, uint64_t count) { out[contact_count_name(kind)] = count; }, counts);
  return out;
}

void clear_contact_counts(Json& counts) {
  for_each_kind([&](v1::ContactKind kind, uint64_t) { counts[contact_count_name(kind)] = nullptr; },
                client::PerKind<uint64_t>{});
}

Json transport_json(const client::FrameStream& stream) {
  Json out = {{"transport", stream.is_local() ? "shared memory" : "grpc"}};
  if (!stream.local_refusal().empty()) out["local_refusal"] = stream.local_refusal();
  return out;
}

Json warnings_json(const std::vector<v1::FrameMetrics>& frames) {
  std::set<std::string> names;
  for (const v1::FrameMetrics& frame : frames) {
    for (const int warning : frame.warnings()) names.insert(v1::FrameWarning_Name(warning));
    for (const std::string& option : frame.unused_options()) names.insert(option + " had no effect");
  }
  return names;
}

}  // namespace collided::cli
