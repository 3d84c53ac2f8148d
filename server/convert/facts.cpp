// Facts about scenes, devices and limits.
#include "server/convert/facts.hpp"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "gpu/stencil.hpp"
#include "server/convert/kinds.hpp"
#include "server/convert/meshes.hpp"
#include "server/convert/options.hpp"
#include "server/refusals/field_path.hpp"

namespace collided::server {
namespace {

void fill_box(const PositionBox& box, pb::QuantizationBox* out) {
  out->mutable_lower()->Assign(box.lower.begin(), box.lower.end());
  out->mutable_upper()->Assign(box.upper.begin(), box.upper.end());
}

void fill_mesh(const MeshPlan& plan, const MeshSpec& engine, pb::MeshSpec* out) {
  out->set_name(plan.name);
  out->set_vertex_count(engine.vertex_count);
  out->set_motion(to_message(engine.motion));
  out->set_groups(engine.groups);
  out->set_collide_mask(engine.collide_mask);
  out->set_no_self_contacts(!engine.self_contacts);
  out->set_exclude_rings(engine.excluded_rings);
  out->set_exclude_rest_pairs(engine.excludes_rest_pairs);
  out->set_half_thickness(engine.half_thickness);
  out->set_solid(engine.solid);
  out->set_triangle_count(static_cast<uint32_t>(plan.triangles));
  out->set_edge_count(static_cast<uint32_t>(plan.edges));
  out->set_point_count(static_cast<uint32_t>(plan.points));
}

void fill_spec(const ScenePlan& plan, pb::SceneSpec* out) {
  const SceneSpec& engine = plan.engine;
  out->set_display_name(plan.display_name);
  out->set_backend(engine.device.backend == Backend::kCuda ? pb::BACKEND_CUDA : pb::BACKEND_CPU);
  out->set_mode(to_message(engine.mode));
  out->set_accuracy(to_message(engine.accuracy));
  out->set_position_format(format_of(engine));
  if (engine.quantized_in) fill_box(*engine.quantized_in, out->mutable_quantization_box());
  out->set_thickness(engine.thickness);
  out->set_delta(engine.delta);
  out->set_min_separation(engine.min_separation);
  out->set_rest_distance(engine.rest_distance);
  for (const auto& [first, second] : engine.excluded_meshes) {
    auto* pair = out->add_excluded_meshes();
    pair->set_first(first);
    pair->set_second(second);
  }
  out->set_report(to_message(engine.report));
  out->set_broad_phase_engine(to_message(engine.engine));
  out->set_reuse(to_message(engine.reuse));
  out->set_expected_contacts(engine.expected[ListLengths::kContacts]);
  if (plan.device) out->set_device(to_string(*plan.device));
  for (const Device& device : engine.part_devices) out->add_part_devices(to_string(device));
  fill_kinds(engine, out);
  fill_fields(plan.fields, out);
  out->set_memory_budget_bytes(engine.memory_budget);
  for (size_t i = 0; i < plan.meshes.size(); ++i) fill_mesh(plan.meshes[i], engine.meshes[i], out->add_meshes());
}

SceneSize size_of(const ScenePlan& plan) {
  SceneSize size{count_vertices(plan.engine)};
  for (const auto& mesh : plan.meshes) size.triangles += mesh.triangles, size.loose += mesh.edges + mesh.points;
  return size;
}

// Positions of all vertices that may have new ones, and the pose of each rigid mesh.
uint64_t whole_frame_bytes(const SceneSpec& spec) {
  constexpr uint64_t kPoseBytes = 12 * sizeof(double);
  uint64_t bytes = 0;
  for (const auto& mesh : spec.meshes) {
    if (mesh.motion == MeshMotion::kDeformable) bytes += mesh.vertex_count * position_bytes(spec);
    if (mesh.motion == MeshMotion::kRigid) bytes += kPoseBytes;
  }
  return bytes;
}

// `out`: an added part.
void fill_part(const MemoryPart& part, pb::MemoryPart* out) {
  out->set_part(part.part);
  out->set_bytes(part.bytes);
}

// Of the wanted fields, those that the engine makes for this kind; none: no contacts are sent.
uint32_t contact_bytes_of(ContactKind kind, FieldSet made, const OutputFields& wanted) {
  if (made == FieldSet{}) return 0;
  const OutputFields sent{made & wanted.columns, wanted.stencils && stencil_finder(kind) != nullptr};
  return static_cast<uint32_t>(sent.contact_bytes());
}

void fill_contact_bytes(const SceneEstimate& estimate, const OutputFields& fields, pb::ContactBytes* out) {
  PerKind<uint32_t> bytes;
  for_each_kind(
      [&](ContactKind kind, FieldSet made, uint32_t& of_kind) { of_kind = contact_bytes_of(kind, made, fields); },
      estimate.fields, bytes);
  fill_bytes_of_kinds(bytes, out);
}

// "max-device-mb" is max_device_bytes.
std::string field_of(std::string option) {
  std::ranges::replace(option, '-', '_');
  constexpr std::string_view kMegabytes = "_mb";
  const size_t at = option.find(kMegabytes);
  return at == std::string::npos ? option : option.replace(at, kMegabytes.size(), "_bytes");
}

void set_field(pb::ServerLimits* out, const google::protobuf::FieldDescriptor* field, uint32_t value) {
  out->GetReflection()->SetUInt32(out, field, value);
}

void set_field(pb::ServerLimits* out, const google::protobuf::FieldDescriptor* field, uint64_t value) {
  out->GetReflection()->SetUInt64(out, field, value);
}

void set_field(pb::ServerLimits* out, const google::protobuf::FieldDescriptor* field, double value) {
  out->GetReflection()->SetDouble(out, field, value);
}

void set_field(pb::ServerLimits* out, const google::protobuf::FieldDescriptor* field, Accuracy value) {
  out->GetReflection()->SetEnumValue(out, field, to_message(value));
}

// Limits without a field are not told. A client cannot keep to them, such as those of connections.
template <class T>
void fill_limit(const char* option, T limit, pb::ServerLimits* out) {
  if (const auto* field = out->GetDescriptor()->FindFieldByName(field_of(option))) set_field(out, field, limit);
}

}  // namespace

void fill_scene(const Scene& scene, pb::Scene* out) {
  const SceneSnapshot now = scene.snapshot();
  out->set_scene_id(scene.id());
  fill_spec(*now.plan, out->mutable_spec());
  out->set_state(now.ready ? pb::SCENE_STATE_READY : pb::SCENE_STATE_AWAITING_MESHES);
  out->set_device(now.device);
  out->set_vertex_count(now.vertices);
  out->set_edge_count(now.edges);
  out->set_triangle_count(now.triangles);
  for (const auto& part : now.memory) fill_part(part, out->add_memory());
  out->set_last_frame_id(now.last_frame_id);
  out->set_lease_seconds(scene.identity().lease_seconds);
  out->set_resume_token(scene.identity().resume_token);
  out->set_endpoint(scene.endpoint());
  out->set_edit_count(now.edits);
  out->set_worlds(now.plan->engine.worlds);
  out->set_device_id(to_string(now.plan->engine.device));
}

void fill_estimate(const ScenePlan& plan, pb::EstimateSceneResponse* out) try {
  const SceneSpec& spec = plan.engine;
  const SceneSize size = size_of(plan);
  const SceneEstimate estimate = estimate_scene(spec, size.vertices, size.elements());
  fill_spec(plan, out->mutable_spec());
  out->set_vertex_count(size.vertices);
  out->set_triangle_count(size.triangles);
  for (const MemoryPart& part : estimate.memory) fill_part(part, out->add_memory());
  fill_part({"host", plan_bytes(plan) + count_tables(spec) * size.elements() * sizeof(TriangleCorners)},
            out->add_memory());
  out->set_first_frame_bytes(size.vertices * position_bytes(spec));
  out->set_frame_bytes(whole_frame_bytes(spec));
  fill_contact_bytes(estimate, plan.fields, out->mutable_contact_bytes());
  for (const std::string& stage : estimate.stages) out->add_stages(stage);
} catch (const InvalidInput& e) {
  throw with_path(e, spec_path);
}

void fill_device(const DeviceState& device, pb::Device* out) {
  out->set_backend(device.info.device.backend == Backend::kCuda ? pb::BACKEND_CUDA : pb::BACKEND_CPU);
  out->set_name(device.info.name);
  out->set_memory_bytes(device.info.memory_bytes);
  out->set_id(to_string(device.info.device));
  out->set_uuid(device.info.uuid);
  out->set_max_bytes(device.max_bytes);
  out->set_free_bytes(device.free_bytes);
  out->set_scenes(device.scenes);
  out->set_load(device.load);
}

void fill_unusable(const UnusableDevice& device, pb::UnusableDevice* out) {
  out->set_backend(pb::BACKEND_CUDA);
  if (device.device) out->set_id(to_string(*device.device));
  out->set_name(device.name);
  out->set_reason(device.reason);
}

void fill_limits(const Limits& limits, const ClientLimits& client, pb::ServerLimits* out) {
  const auto fill = [out](const auto& row, const auto& limit) { fill_limit(row.option, limit, out); };
  Limits both = limits;
  both.client = client;
  for_each_limit(fill, both);
  out->set_min_ping_seconds(kMinPingSeconds);
}

}  // namespace collided::server
