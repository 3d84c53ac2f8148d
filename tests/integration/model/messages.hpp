#pragma once
// The model's scenes and frames as messages of the protocol.

#include "tests/integration/model/scene_model.hpp"
#include "tests/integration/support/calls.hpp"
#include "tests/integration/support/positions.hpp"

namespace collided::test {

inline std::string floats(const Positions& positions) { return pack_points(positions); }

inline pb::MeshSpec message_of(const ModelMesh& mesh, const std::string& name) {
  constexpr pb::MeshMotion kMotions[] = {pb::MESH_MOTION_DEFORMABLE, pb::MESH_MOTION_STATIC, pb::MESH_MOTION_RIGID};
  pb::MeshSpec spec;
  spec.set_name(name);
  spec.set_vertex_count(mesh.vertex_count);
  spec.set_motion(mesh.motion == MeshMotion::kStatic  ? kMotions[1]
                  : mesh.motion == MeshMotion::kRigid ? kMotions[2]
                                                      : kMotions[0]);
  spec.set_triangles(pack(mesh.triangles));
  return spec;
}

inline pb::SceneSpec spec_of(const std::vector<ModelMesh>& meshes, pb::DetectionMode mode, double thickness) {
  pb::SceneSpec spec;
  spec.set_mode(mode);
  spec.set_accuracy(pb::ACCURACY_EXACT);
  spec.set_thickness(thickness);
  if (mode != pb::DETECTION_MODE_DCD) spec.set_min_separation(thickness);
  for (size_t m = 0; m < meshes.size(); ++m) *spec.add_meshes() = message_of(meshes[m], "mesh" + std::to_string(m));
  return spec;
}

inline pb::MeshUpdate message_of(const ModelUpdate& update) {
  pb::MeshUpdate message;
  message.set_mesh(update.mesh);
  if (update.sparse) message.mutable_sparse()->set_indices(pack(*update.sparse));
  if (update.matrix)
    message.mutable_rigid()->set_matrix(pack(std::vector<double>(update.matrix->begin(), update.matrix->end())));
  if (update.start) message.set_start_positions(floats(*update.start));
  message.set_positions(floats(update.end));
  return message;
}

inline pb::Frame message_of(const ModelFrame& frame) {
  pb::Frame message;
  message.set_frame_id(frame.id);
  message.set_trial(frame.trial);
  message.set_advance(frame.advance);
  if (frame.from_last) message.set_from_last_fraction(*frame.from_last);
  for (const ModelUpdate& update : frame.updates) *message.add_updates() = message_of(update);
  for (const ModelEdit& edit : frame.edits) {
    auto* mesh = message.mutable_edit()->add_meshes();
    mesh->set_mesh(edit.mesh);
    if (edit.as.vertex_count > 0) *mesh->mutable_spec() = message_of(edit.as, "mesh" + std::to_string(edit.mesh));
  }
  return message;
}

}  // namespace collided::test
