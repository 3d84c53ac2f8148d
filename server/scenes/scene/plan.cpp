// Plans of scenes: what they count, and what an edit makes of them.
#include "server/scenes/scene/plan.hpp"

#include <set>
#include <utility>

#include "server/devices/sharded_bytes.hpp"

namespace collided::server {
namespace {

// A copy; the elements are never copied.
MeshSpec without_elements(MeshSpec& mesh) {
  auto triangles = std::exchange(mesh.triangles, {});
  auto edges = std::exchange(mesh.edges, {});
  auto points = std::exchange(mesh.points, {});
  MeshSpec out = mesh;
  mesh.triangles = std::move(triangles);
  mesh.edges = std::move(edges);
  mesh.points = std::move(points);
  return out;
}

}  // namespace

std::vector<Device> devices_of(const SceneSpec& spec) {
  if (spec.part_devices.empty()) return {spec.device};
  const std::set<Device> devices(spec.part_devices.begin(), spec.part_devices.end());
  return {devices.begin(), devices.end()};
}

ScenePlan without_elements(ScenePlan& plan) {
  auto meshes = std::exchange(plan.engine.meshes, {});
  ScenePlan out = plan;
  for (MeshSpec& mesh : meshes) out.engine.meshes.push_back(without_elements(mesh));
  plan.engine.meshes = std::move(meshes);
  return out;
}

SceneQuota::SceneQuota(const ScenePlan& plan)
    : whole(DeviceBytes::of_scene(plan.engine.memory_budget, plan.quota)), of_engine(whole) {
  if (plan.shards.empty()) return;
  const auto sharded = std::make_shared<ShardedBytes>(whole, plan.shards);
  whole = sharded->whole();
  of_engine = sharded;
}

uint64_t max_edit_bytes(const SceneEdit& edit) {
  constexpr uint64_t kOfElement = sizeof(TriangleCorners) + 3 * sizeof(std::array<uint32_t, 2>);
  uint64_t bytes = edit.excluded.size() * kPairBytes;
  for (const auto& [mesh, spec] : edit.meshes)
    bytes += kMeshBytes + kPoseBytes + kMaxNameBytes + count_elements(spec) * kOfElement;
  return bytes;
}

ScenePlan edited_plan(const ScenePlan& before, const std::vector<EditedMesh>& edited, const SceneSpec& engine) {
  ScenePlan plan = before;
  plan.engine.meshes = engine.meshes;
  plan.engine.excluded_meshes = engine.excluded_meshes;
  plan.engine.rest_distance = engine.rest_distance;
  plan.meshes.resize(engine.meshes.size());
  for (const EditedMesh& edit : edited) {
    MeshPlan& mesh = plan.meshes[edit.mesh];
    if (!edit.name.empty()) mesh.name = edit.name;
    if (!edit.keeps_elements) mesh = {mesh.name, edit.triangles, 0, edit.edges, edit.points};
    if (engine.meshes[edit.mesh].vertex_count == 0) mesh = {};
  }
  return plan;
}

}  // namespace collided::server
