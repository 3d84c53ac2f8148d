#pragma once
// Meshes, frames and edits from a command's numbers. All are good; bad ones are made of them.

#include "tests/integration/model/command.hpp"
#include "tests/integration/model/messages.hpp"

namespace collided::test {

Positions any_positions(Numbers& numbers, size_t count);
ModelMesh any_mesh(Numbers& numbers, bool may_be_rigid);
std::vector<ModelMesh> any_meshes(Numbers& numbers);

/// For a scene of this mode, as its edits leave it.
ModelFrame any_frame(Numbers& numbers, const SceneModel& scene, pb::DetectionMode mode);
/// A frame with an edit, for a scene that had a frame.
ModelFrame any_edit(Numbers& numbers, const SceneModel& scene, pb::DetectionMode mode);

/// Makes a frame bad in one way; the code that it is refused with, or OK where nothing could be made bad.
grpc::StatusCode spoil(Numbers& numbers, const SceneModel& scene, pb::Frame& frame);

}  // namespace collided::test
