#include "tests/integration/model/choices.hpp"

#include <limits>

namespace collided::test {
namespace {

/// Steps along the axes; turns would leave straight lines.
std::array<double, 12> any_shift(Numbers& numbers) {
  std::array<double, 12> matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  for (const size_t k : {3, 7, 11}) matrix[k] = numbers.coordinate();
  return matrix;
}

ModelUpdate any_update(Numbers& numbers, const SceneModel& scene, uint32_t m, bool has_starts) {
  const ModelMesh& mesh = scene.meshes()[m];
  ModelUpdate update{.mesh = m, .sparse = {}, .matrix = {}, .start = {}, .end = {}};
  if (mesh.motion == MeshMotion::kRigid) {
    if (scene.awaits(m)) update.end = any_positions(numbers, mesh.vertex_count);
    if (!scene.awaits(m) || numbers.one_in(2)) update.matrix = any_shift(numbers);
    return update;
  }
  size_t count = mesh.vertex_count;
  if (!scene.awaits(m) && numbers.one_in(3)) {
    update.sparse.emplace();
    for (uint32_t v = 0; v < mesh.vertex_count; ++v)
      if (numbers.one_in(2)) update.sparse->push_back(v);
    count = update.sparse->size();
  }
  update.end = any_positions(numbers, count);
  if (has_starts && mesh.motion == MeshMotion::kDeformable && count > 0 && numbers.one_in(3))
    update.start = any_positions(numbers, count);
  return update;
}

bool has_rigid(const SceneModel& scene) {
  for (const ModelMesh& mesh : scene.meshes())
    if (mesh.vertex_count > 0 && mesh.motion == MeshMotion::kRigid) return true;
  return false;
}

void add_updates(Numbers& numbers, const SceneModel& scene, pb::DetectionMode mode, ModelFrame& frame) {
  for (uint32_t m = 0; m < scene.meshes().size(); ++m) {
    const ModelMesh& mesh = scene.meshes()[m];
    if (mesh.vertex_count == 0) continue;
    const bool moves = mesh.motion != MeshMotion::kStatic && !numbers.one_in(3);
    if (scene.awaits(m) || moves)
      frame.updates.push_back(any_update(numbers, scene, m, mode != pb::DETECTION_MODE_DCD));
  }
}

bool was_there(const SceneModel& scene, uint32_t mesh) {
  return mesh < scene.meshes().size() && scene.meshes()[mesh].vertex_count > 0;
}

}  // namespace

Positions any_positions(Numbers& numbers, size_t count) {
  Positions positions(count);
  for (Vec3d& p : positions)
    for (double& x : p) x = numbers.coordinate();
  return positions;
}

ModelMesh any_mesh(Numbers& numbers, bool may_be_rigid) {
  ModelMesh mesh;
  const uint32_t motion = numbers.below(may_be_rigid ? 5 : 4);
  mesh.motion = motion == 4 ? MeshMotion::kRigid : motion == 3 ? MeshMotion::kStatic : MeshMotion::kDeformable;
  mesh.vertex_count = 3 + numbers.below(3);
  const uint32_t triangles = 1 + numbers.below(4);
  for (uint32_t t = 0; t < triangles; ++t) {
    const uint32_t a = numbers.below(mesh.vertex_count), b = 1 + numbers.below(mesh.vertex_count - 1),
                   c = 1 + numbers.below(mesh.vertex_count - 2);
    const uint32_t second = (a + b) % mesh.vertex_count;
    uint32_t third = a;
    for (uint32_t left = c; left > 0;) {
      third = (third + 1) % mesh.vertex_count;
      if (third != second && third != a) --left;
    }
    mesh.triangles.push_back({a, second, third});
  }
  return mesh;
}

std::vector<ModelMesh> any_meshes(Numbers& numbers) {
  std::vector<ModelMesh> meshes;
  const uint32_t count = 1 + numbers.below(3);
  const bool may_be_rigid = numbers.one_in(2);
  for (uint32_t m = 0; m < count; ++m) meshes.push_back(any_mesh(numbers, may_be_rigid));
  return meshes;
}

ModelFrame any_frame(Numbers& numbers, const SceneModel& scene, pb::DetectionMode mode) {
  ModelFrame frame;
  frame.id = scene.last_frame_id() + 1 + numbers.below(3);
  frame.discrete = mode == pb::DETECTION_MODE_DCD || (mode == pb::DETECTION_MODE_DCD_AND_CCD && numbers.one_in(2));
  frame.trial = numbers.one_in(5);
  const bool steps = mode == pb::DETECTION_MODE_CCD && !frame.trial && !has_rigid(scene);
  frame.advance = numbers.one_in(4) && steps;
  const uint32_t fraction = numbers.below(5);
  if (numbers.one_in(4) && steps && !frame.advance && scene.had_a_frame() && scene.has_way())
    frame.from_last = fraction / 4.0;
  add_updates(numbers, scene, mode, frame);
  return frame;
}

ModelFrame any_edit(Numbers& numbers, const SceneModel& scene, pb::DetectionMode mode) {
  ModelFrame frame;
  frame.id = scene.last_frame_id() + 1;
  frame.discrete = mode == pb::DETECTION_MODE_DCD;
  const auto count = static_cast<uint32_t>(scene.meshes().size());
  ModelEdit edit{.mesh = numbers.below(count + (count < 4 ? 1 : 0)), .as = any_mesh(numbers, true)};
  uint32_t others = 0;
  for (uint32_t m = 0; m < count; ++m) others += m != edit.mesh && was_there(scene, m) ? 1 : 0;
  if (was_there(scene, edit.mesh) && others > 0 && numbers.one_in(2)) edit.as = {};
  frame.edits.push_back(edit);
  const SceneModel after = scene.edited(frame);
  add_updates(numbers, after, mode, frame);
  // Nothing else tells where the vertices of a mesh that was there before begin.
  for (ModelUpdate& update : frame.updates)
    if (mode != pb::DETECTION_MODE_DCD && update.mesh == edit.mesh && was_there(scene, edit.mesh) &&
        after.awaits(edit.mesh) && edit.as.motion == MeshMotion::kDeformable)
      update.start = any_positions(numbers, edit.as.vertex_count);
  return frame;
}

grpc::StatusCode spoil(Numbers& numbers, const SceneModel& scene, pb::Frame& frame) {
  const uint32_t way = numbers.below(9);
  if (way == 0) {
    frame.set_frame_id(scene.last_frame_id());
    return scene.had_a_frame() ? grpc::FAILED_PRECONDITION : grpc::INVALID_ARGUMENT;
  }
  if (way == 1) {
    frame.add_updates()->set_mesh(static_cast<uint32_t>(scene.meshes().size()));
    return grpc::INVALID_ARGUMENT;
  }
  if (way == 2) {
    frame.set_delta(-1);
    return grpc::INVALID_ARGUMENT;
  }
  if (frame.updates().empty()) return grpc::OK;
  pb::MeshUpdate& update =
      *frame.mutable_updates(static_cast<int>(numbers.below(static_cast<uint32_t>(frame.updates_size()))));
  if (way == 3) {
    const pb::MeshUpdate again = update;
    *frame.add_updates() = again;
    return grpc::INVALID_ARGUMENT;
  }
  if (way == 4) {
    update.mutable_positions()->push_back('\0');
    return grpc::INVALID_ARGUMENT;
  }
  if (update.has_sparse() && update.sparse().indices().size() >= 8 && way == 5) {
    std::string& indices = *update.mutable_sparse()->mutable_indices();
    indices.replace(0, 4, indices.substr(4, 4));
    return grpc::INVALID_ARGUMENT;
  }
  if (update.has_sparse() && way == 6) {
    update.mutable_sparse()->mutable_indices()->append(pack<uint32_t>({9}));
    update.mutable_positions()->append(12, '\0');
    if (!update.start_positions().empty()) update.mutable_start_positions()->append(12, '\0');
    return grpc::INVALID_ARGUMENT;
  }
  if (update.positions().empty()) return grpc::OK;
  const float bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                       std::numeric_limits<float>::max()};
  update.mutable_positions()->replace(update.positions().size() - 4, 4, pack<float>({bad[numbers.below(3)]}));
  return grpc::INVALID_ARGUMENT;
}

}  // namespace collided::test
