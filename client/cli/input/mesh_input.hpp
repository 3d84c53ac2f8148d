#pragma once
// Meshes of a scene and their positions, in the form that a daemon takes.

#include <vector>

#include "client/cpp/client.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// The inputs borrow the meshes' triangles.
std::vector<client::MeshInput> mesh_inputs(const std::vector<scenes::Mesh>& meshes);

/// One frame of all moving meshes; the frame of id 1 has the static ones as well. Positions are those of all meshes, in
/// their order. Without `start` the meshes start where the last frame ended.
v1::Frame make_frame(const std::vector<scenes::Mesh>& meshes, uint64_t id, v1::PositionFormat format,
                     client::Positions end, client::Positions start = {});

}  // namespace collided::cli
