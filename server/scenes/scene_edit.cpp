// Edits of a scene: its plan follows what the engine has made of it.
#include <spdlog/fmt/fmt.h>

#include <utility>

#include "server/errors.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

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

void Scene::throw_edited(uint64_t frame_id) const {
  throw FailedPrecondition("frame",
                           fmt::format("frame {} came before scene {} was edited by frame {}, and does not fit "
                                       "it any more; send it again",
                                       frame_id, id(), shown_.last_frame_id));
}

// The engine has applied it.
void Scene::take_edit(const FrameBasis& basis, MemoryHold& making) {
  auto plan = std::make_shared<const ScenePlan>(edited_plan(*shown_.plan, basis.edited, detector_->spec()));
  auto slots = std::make_shared<SlotPool>(detector_);
  {
    const std::lock_guard lock(mutex_);
    shown_.plan = std::move(plan);
    slots_.swap(slots);
    awaited_.resize(shown_.plan->meshes.size(), 0);
    uploading_.resize(shown_.plan->meshes.size(), false);
    shown_.vertices = detector_->topology().vertex_count;
    shown_.triangles = 0;
    for (const MeshPlan& mesh : shown_.plan->meshes) shown_.triangles += mesh.triangles;
    ++shown_.edits;
  }
  if (slots) slots->close();
  held_.absorb(making);
  held_.resize(host_bytes());
}

}  // namespace collided::server
