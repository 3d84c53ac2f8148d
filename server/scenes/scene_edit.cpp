// Edits of a scene: its plan follows what the engine has made of it.
#include <spdlog/fmt/fmt.h>

#include <utility>

#include "server/errors.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

uint64_t max_edit_bytes(const SceneEdit& edit) {
  constexpr uint64_t kOfTriangle = sizeof(TriangleCorners) + 3 * sizeof(std::array<uint32_t, 2>);
  constexpr uint64_t kMaxNameBytes = 128;
  uint64_t bytes = edit.excluded.size() * kPairBytes;
  for (const auto& [mesh, spec] : edit.meshes)
    bytes += kMeshBytes + kPoseBytes + kMaxNameBytes + spec.triangles.size() * kOfTriangle;
  return bytes;
}

ScenePlan edited_plan(const ScenePlan& before, const std::vector<EditedMesh>& edited, const SceneSpec& engine,
                      const Topology& topology) {
  ScenePlan plan = before;
  plan.engine.meshes = engine.meshes;
  plan.engine.excluded_meshes = engine.excluded_meshes;
  plan.engine.rest_distance = engine.rest_distance;
  plan.meshes.resize(engine.meshes.size());
  for (const auto& [mesh, name] : edited)
    if (!name.empty()) plan.meshes[mesh].name = name;
  for (size_t i = 0; i < plan.meshes.size(); ++i) {
    plan.meshes[i].triangles = topology.triangle_offset[i + 1] - topology.triangle_offset[i];
    if (engine.meshes[i].vertex_count == 0) plan.meshes[i].name.clear();
  }
  return plan;
}

void Scene::throw_edited(uint64_t frame_id) const {
  throw FailedPrecondition("frame",
                           fmt::format("frame {} came before scene {} was edited by frame {}, and does not fit "
                                       "it any more; send it again",
                                       frame_id, id(), shown_.last_frame_id));
}

// The engine has applied it.
void Scene::take_edit(const FrameBasis& basis, MemoryHold& making) {
  auto plan = std::make_shared<const ScenePlan>(
      edited_plan(*shown_.plan, basis.edited, detector_->spec(), detector_->topology()));
  auto slots = std::make_shared<SlotPool>(detector_);
  {
    const std::lock_guard lock(mutex_);
    shown_.plan = std::move(plan);
    slots_.swap(slots);
    awaited_.resize(shown_.plan->meshes.size(), 0);
    uploading_.resize(shown_.plan->meshes.size(), false);
    shown_.vertices = detector_->topology().vertex_count;
    shown_.triangles = detector_->topology().triangles.size();
    ++shown_.edits;
  }
  if (slots) slots->close();
  held_.absorb(making);
  held_.resize(plan_bytes(*shown_.plan) + topology_bytes(detector_->topology()));
}

}  // namespace collided::server
