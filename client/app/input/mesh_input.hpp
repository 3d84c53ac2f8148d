#pragma once
// Meshes of a scene and their positions, in the form that a daemon takes.

#include <vector>

#include "client/cpp/client.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// The inputs borrow the meshes' triangles.
std::vector<client::MeshInput> mesh_inputs(const std::vector<scenes::Mesh>& meshes);

/// Makes room for the positions in the box that they are encoded in; nothing for a format without one.
void grow_box(v1::SceneSpec& spec, client::Positions positions);

/// One frame of all moving meshes, in the format of the spec; the frame of id 1 has the static ones as well. Positions
/// are those of all meshes, in their order. Without `start` the meshes start where the last frame ended.
v1::Frame make_frame(const std::vector<scenes::Mesh>& meshes, uint64_t id, const v1::SceneSpec& spec,
                     client::Positions end, client::Positions start = {});

}  // namespace collided::cli
