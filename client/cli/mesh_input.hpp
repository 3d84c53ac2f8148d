#pragma once
// Meshes of a scene as a daemon takes them.

#include <vector>

#include "client/cpp/client.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// The inputs borrow the meshes' triangles.
inline std::vector<client::MeshInput> mesh_inputs(const std::vector<scenes::Mesh>& meshes) {
  std::vector<client::MeshInput> out;
  for (const scenes::Mesh& mesh : meshes) out.push_back({mesh.name, mesh.vertex_count, mesh.triangles, mesh.is_static});
  return out;
}

}  // namespace collided::cli
