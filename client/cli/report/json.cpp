// A scene and its frames as JSON.

#include "client/cli/report/json.hpp"

#include <set>

#include "client/cli/options/options.hpp"

namespace collided::cli {

Json scene_json(const v1::Scene& scene) {
  const v1::SceneSpec& spec = scene.spec();
  Json kinds = Json::array();
  for (const int kind : spec.kinds()) kinds.push_back(name_of(static_cast<v1::ContactKind>(kind)));
  return {{"vertices", scene.vertex_count()},
          {"edges", scene.edge_count()},
          {"triangles", scene.triangle_count()},
          {"meshes", spec.meshes_size()},
          {"backend", name_of(spec.backend())},
          {"device", scene.device()},
          {"mode", spec.mode() == v1::DETECTION_MODE_DCD ? "dcd" : "ccd"},
          {"accuracy", name_of(spec.accuracy())},
          {"position_format", name_of(spec.position_format())},
          {"thickness", spec.thickness()},
          {"delta", spec.delta()},
          {"report", name_of(spec.report())},
          {"kinds", kinds},
          {"engine", name_of(spec.broad_phase_engine())}};
}

Json stages_json(const v1::FrameMetrics& metrics) {
  Json out = Json::object();
  for (const v1::StageTime& stage : metrics.stages())
    out[stage.stage()] = out.value(stage.stage(), 0.0) + stage.milliseconds();
  return out;
}

Json counts_json(const v1::FrameCounts& c) {
  return {{"cells", c.cells()},
          {"leaves", c.leaves()},
          {"top_level", c.top_level()},
          {"base_level", c.base_level()},
          {"registrations", c.registrations()},
          {"tests", c.tests()},
          {"pairs", c.pairs()},
          {"candidates_vertex_triangle", c.candidates_vertex_triangle()},
          {"candidates_edge_edge", c.candidates_edge_edge()},
          {"contacts_vertex_triangle", c.contacts_vertex_triangle()},
          {"contacts_edge_edge", c.contacts_edge_edge()},
          {"contacts_triangle_triangle", c.contacts_triangle_triangle()},
          {"survivors_vertex_triangle", c.survivors_vertex_triangle()},
          {"survivors_edge_edge", c.survivors_edge_edge()},
          {"exact_decisions", c.exact_decisions()}};
}

Json frame_json(const v1::FrameDone& done, v1::Report report) {
  const v1::FrameMetrics& m = done.metrics();
  Json out = {{"total_ms", m.total_milliseconds()},
              {"queue_ms", m.queue_milliseconds()},
              {"step_ms", m.step_milliseconds()},
              {"stage_ms", stages_json(m)},
              {"engine", name_of(m.broad_phase_engine())},
              {"counts", counts_json(m.counts())},
              {"replays", m.replays()},
              {"allocations", m.allocations()},
              {"graph_launches", m.graph_launches()},
              {"device_bytes", m.device_bytes()},
              {"bytes_in", m.bytes_in()},
              {"bytes_out", m.bytes_out()},
              {"warnings", warnings_json({m})}};
  if (report == v1::REPORT_ANY_HIT) clear_contact_counts(out["counts"]);
  return out;
}

void clear_contact_counts(Json& counts) {
  for (const char* name : {"contacts_vertex_triangle", "contacts_edge_edge", "contacts_triangle_triangle"})
    counts[name] = nullptr;
}

Json transport_json(const client::FrameStream& stream) {
  Json out = {{"transport", stream.is_local() ? "shared memory" : "grpc"}};
  if (!stream.local_refusal().empty()) out["local_refusal"] = stream.local_refusal();
  return out;
}

Json warnings_json(const std::vector<v1::FrameMetrics>& frames) {
  std::set<std::string> names;
  for (const v1::FrameMetrics& frame : frames)
    for (const int warning : frame.warnings()) names.insert(v1::FrameWarning_Name(warning));
  return names;
}

}  // namespace collided::cli
