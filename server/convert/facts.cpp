// Facts about scenes, devices and limits.
#include "server/convert/facts.hpp"

#include "server/convert/kinds.hpp"
#include "server/convert/options.hpp"

namespace collided::server {
namespace {

void fill_mesh(const MeshPlan& plan, const MeshSpec& engine, pb::MeshSpec* out) {
  out->set_name(plan.name);
  out->set_vertex_count(engine.vertex_count);
  out->set_motion(engine.motion == MeshMotion::kStatic ? pb::MESH_MOTION_STATIC : pb::MESH_MOTION_DEFORMABLE);
  out->set_groups(engine.groups);
  out->set_collide_mask(engine.collide_mask);
  out->set_no_self_contacts(!engine.self_contacts);
  out->set_exclude_rings(engine.excluded_rings);
  out->set_exclude_rest_pairs(engine.excludes_rest_pairs);
  out->set_triangle_count(static_cast<uint32_t>(plan.triangles));
}

void fill_spec(const ScenePlan& plan, pb::SceneSpec* out) {
  const SceneSpec& engine = plan.engine;
  out->set_display_name(plan.display_name);
  out->set_backend(engine.backend == Backend::kCuda ? pb::BACKEND_CUDA : pb::BACKEND_CPU);
  out->set_mode(engine.mode == Mode::kCcd ? pb::DETECTION_MODE_CCD : pb::DETECTION_MODE_DCD);
  out->set_accuracy(to_message(engine.accuracy));
  out->set_position_format(to_message(engine.scalar));
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
  fill_kinds(engine, out);
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
  out->set_lease_seconds(scene.facts().lease_seconds);
  out->set_resume_token(scene.facts().resume_token);
  out->set_endpoint(scene.endpoint());
}

void fill_device(const DeviceInfo& device, pb::Device* out) {
  out->set_backend(device.backend == Backend::kCuda ? pb::BACKEND_CUDA : pb::BACKEND_CPU);
  out->set_name(device.name);
  out->set_memory_bytes(device.memory_bytes);
}

void fill_limits(const Limits& limits, const ClientLimits& client, pb::ServerLimits* out) {
  out->set_max_message_bytes(limits.max_message_bytes);
  out->set_max_vertices(limits.max_vertices);
  out->set_max_triangles(limits.max_triangles);
  out->set_max_scenes(limits.max_scenes);
  out->set_max_scene_bytes(limits.max_scene_bytes);
  out->set_max_window(limits.max_window);
  out->set_max_scenes_per_client(client.max_scenes);
  out->set_max_device_bytes_per_client(client.max_device_bytes);
  out->set_max_device_bytes(limits.max_device_bytes);
  out->set_max_streams(limits.max_streams);
  out->set_max_streams_per_client(client.max_streams);
  out->set_max_frames_per_second(client.max_frames_per_second);
  out->set_max_frame_seconds(client.max_frame_seconds);
  out->set_max_accuracy(to_message(client.max_accuracy));
  out->set_max_idle_seconds(limits.max_idle_seconds);
  out->set_max_lease_seconds(limits.max_lease_seconds);
}

}  // namespace collided::server
