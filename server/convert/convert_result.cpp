// Results and facts from the engine to the protocol.
#include <algorithm>

#include "server/convert/convert.hpp"
#include "server/convert/convert_level.hpp"

namespace collided::server {
namespace {

template <class T>
void put(std::string* out, const T& value) {
  out->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

// A run of an engine array, whose elements have the wire's layout.
template <class T>
void put_run(std::string* out, const std::vector<T>& values, size_t begin, size_t end) {
  out->assign(reinterpret_cast<const char*>(values.data() + begin), (end - begin) * sizeof(T));
}

std::array<uint32_t, 4> stencil(pb::ContactKind kind, std::array<uint32_t, 2> pair, const Topology& topology) {
  if (kind == pb::CONTACT_KIND_VERTEX_TRIANGLE) {
    const auto& triangle = topology.triangles[pair[1]];
    return {pair[0], triangle[0], triangle[1], triangle[2]};
  }
  const auto &a = topology.edges[pair[0]], &b = topology.edges[pair[1]];
  return {a[0], a[1], b[0], b[1]};
}

// Those of the fields asked for that there are of this kind, at the level of this frame.
OutputFields available(OutputFields fields, pb::ContactKind kind, const ContactSet& set) {
  fields.stencils &= kind != pb::CONTACT_KIND_TRIANGLE_TRIANGLE;
  fields.toi &= !set.toi.empty();
  fields.distance &= !set.distance.empty();
  fields.weights &= !set.weights.empty();
  fields.flags &= !set.flags.empty();
  return fields;
}

struct ChunkSource {
  pb::ContactKind kind;
  const ContactSet& set;
  const Topology& topology;
  OutputFields fields;

  pb::ContactChunk chunk(size_t begin, size_t end) const {
    pb::ContactChunk out;
    out.set_kind(kind);
    out.set_count(static_cast<uint32_t>(end - begin));
    if (fields.elements) put_run(out.mutable_elements(), set.elements, begin, end);
    if (fields.toi) put_run(out.mutable_toi(), set.toi, begin, end);
    if (fields.distance) put_run(out.mutable_distance(), set.distance, begin, end);
    if (fields.weights) put_run(out.mutable_weights(), set.weights, begin, end);
    if (fields.flags) put_run(out.mutable_flags(), set.flags, begin, end);
    if (!fields.stencils) return out;
    out.mutable_stencils()->reserve((end - begin) * sizeof(std::array<uint32_t, 4>));
    for (size_t i = begin; i < end; ++i) put(out.mutable_stencils(), stencil(kind, set.elements[i], topology));
    return out;
  }
};

void fill_counts(const FrameCounts& counts, pb::FrameCounts* out) {
  out->set_cells(counts.cells);
  out->set_leaves(counts.leaves);
  out->set_top_level(counts.top_level);
  out->set_base_level(counts.base_level);
  out->set_registrations(counts.registrations);
  out->set_tests(counts.tests);
  out->set_pairs(counts.pairs);
  out->set_candidates_vertex_triangle(counts.candidates_vt);
  out->set_candidates_edge_edge(counts.candidates_ee);
  out->set_contacts_vertex_triangle(counts.contacts_vt);
  out->set_contacts_edge_edge(counts.contacts_ee);
  out->set_contacts_triangle_triangle(counts.contacts_tt);
  out->set_survivors_vertex_triangle(counts.survivors_vt);
  out->set_survivors_edge_edge(counts.survivors_ee);
  out->set_exact_decisions(counts.exact_decisions);
}

void fill_mesh(const MeshPlan& plan, const MeshSpec& engine, pb::MeshSpec* out) {
  out->set_name(plan.name);
  out->set_vertex_count(engine.vertex_count);
  out->set_motion(engine.is_static ? pb::MESH_MOTION_STATIC : pb::MESH_MOTION_DEFORMABLE);
  out->set_groups(engine.groups);
  out->set_collide_mask(engine.collide_mask);
  out->set_no_self_contacts(!engine.self_contacts);
  out->set_triangle_count(static_cast<uint32_t>(plan.awaited));
}

void fill_fields(const OutputFields& fields, pb::SceneSpec* out) {
  if (fields.elements) out->add_fields(pb::CONTACT_FIELD_ELEMENTS);
  if (fields.stencils) out->add_fields(pb::CONTACT_FIELD_STENCIL);
  if (fields.toi) out->add_fields(pb::CONTACT_FIELD_TOI);
  if (fields.distance) out->add_fields(pb::CONTACT_FIELD_DISTANCE);
  if (fields.weights) out->add_fields(pb::CONTACT_FIELD_WEIGHTS);
  if (fields.flags) out->add_fields(pb::CONTACT_FIELD_FLAGS);
}

void fill_spec(const ScenePlan& plan, pb::SceneSpec* out) {
  const SceneSpec& engine = plan.engine;
  out->set_display_name(plan.display_name);
  out->set_backend(engine.backend == Backend::kCuda ? pb::BACKEND_CUDA : pb::BACKEND_CPU);
  out->set_mode(engine.mode == Mode::kCcd ? pb::DETECTION_MODE_CCD : pb::DETECTION_MODE_DCD);
  out->set_accuracy(to_message(engine.accuracy));
  out->set_position_format(engine.scalar == Scalar::kF64 ? pb::POSITION_FORMAT_F64 : pb::POSITION_FORMAT_F32);
  out->set_thickness(engine.thickness);
  out->set_delta(engine.delta);
  out->set_report(to_message(engine.report));
  out->set_broad_phase_engine(to_message(engine.engine));
  if (engine.vertex_triangle) out->add_kinds(pb::CONTACT_KIND_VERTEX_TRIANGLE);
  if (engine.edge_edge) out->add_kinds(pb::CONTACT_KIND_EDGE_EDGE);
  if (engine.triangle_triangle) out->add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
  fill_fields(plan.fields, out);
  out->set_memory_budget_bytes(engine.memory_budget);
  for (size_t i = 0; i < plan.meshes.size(); ++i) fill_mesh(plan.meshes[i], engine.meshes[i], out->add_meshes());
}

}  // namespace

void fill_scene(const Scene& scene, pb::Scene* out) {
  const SceneSnapshot now = scene.snapshot();
  out->set_scene_id(scene.id());
  fill_spec(scene.plan(), out->mutable_spec());
  out->set_state(now.ready ? pb::SCENE_STATE_READY : pb::SCENE_STATE_AWAITING_MESHES);
  out->set_device(now.device);
  out->set_vertex_count(now.vertices);
  out->set_edge_count(now.edges);
  out->set_triangle_count(now.triangles);
  for (const auto& part : now.memory) {
    auto* added = out->add_memory();
    added->set_part(part.part);
    added->set_bytes(part.bytes);
  }
  out->set_last_frame_id(now.last_frame_id);
}

void fill_device(const DeviceInfo& device, pb::Device* out) {
  out->set_backend(device.backend == Backend::kCuda ? pb::BACKEND_CUDA : pb::BACKEND_CPU);
  out->set_name(device.name);
  out->set_memory_bytes(device.memory_bytes);
}

void fill_limits(const Limits& limits, pb::ServerLimits* out) {
  out->set_max_message_bytes(limits.max_message_bytes);
  out->set_max_vertices(limits.max_vertices);
  out->set_max_triangles(limits.max_triangles);
  out->set_max_scenes(limits.max_scenes);
  out->set_max_scene_bytes(limits.max_scene_bytes);
  out->set_max_window(limits.max_window);
}

void fill_done(const FrameResult& result, const FrameCost& cost, pb::FrameDone* out) {
  auto* metrics = out->mutable_metrics();
  for (const auto& stage : result.stages) {
    auto* added = metrics->add_stages();
    added->set_stage(stage.stage);
    added->set_milliseconds(stage.milliseconds);
  }
  fill_counts(result.counts, metrics->mutable_counts());
  metrics->set_total_milliseconds(cost.total_milliseconds);
  metrics->set_queue_milliseconds(cost.queue_milliseconds);
  metrics->set_device_bytes(cost.device_bytes);
  metrics->set_replays(result.replays);
  metrics->set_allocations(result.allocations);
  metrics->set_graph_launches(result.graph_launches);
  metrics->set_step_milliseconds(result.step_milliseconds);
  metrics->set_broad_phase_engine(to_message(result.engine));
  metrics->set_bytes_in(cost.bytes_in);
  metrics->set_bytes_out(cost.bytes_out);
  if (result.input_resolution) metrics->add_warnings(pb::FRAME_WARNING_INPUT_RESOLUTION);
  out->set_contact_count(result.vertex_triangle.size() + result.edge_edge.size() + result.triangle_triangle.size());
  out->set_earliest_toi(result.earliest_toi);
  out->set_any_contact(result.any_contact);
}

std::vector<pb::ContactChunk> make_chunks(const FrameResult& result, const Topology& topology,
                                          const OutputFields& fields, size_t max_bytes) {
  std::vector<pb::ContactChunk> chunks;
  const auto append = [&](pb::ContactKind kind, const ContactSet& set) {
    const ChunkSource source{kind, set, topology, available(fields, kind, set)};
    const size_t step = std::max<size_t>(1, max_bytes / std::max<size_t>(1, source.fields.contact_bytes()));
    for (size_t begin = 0; begin < set.size(); begin += step)
      chunks.push_back(source.chunk(begin, std::min(begin + step, set.size())));
  };
  append(pb::CONTACT_KIND_VERTEX_TRIANGLE, result.vertex_triangle);
  append(pb::CONTACT_KIND_EDGE_EDGE, result.edge_edge);
  append(pb::CONTACT_KIND_TRIANGLE_TRIANGLE, result.triangle_triangle);
  return chunks;
}

uint64_t array_bytes(const std::vector<pb::ContactChunk>& chunks) {
  uint64_t bytes = 0;
  for (const auto& chunk : chunks)
    bytes += chunk.elements().size() + chunk.stencils().size() + chunk.toi().size() + chunk.distance().size() +
             chunk.weights().size() + chunk.flags().size();
  return bytes;
}

}  // namespace collided::server
