#pragma once
// What is drawn of a scene: all vertices, or one of so many and the coarser surface that they span.

#include <array>
#include <cstdint>
#include <vector>

#include "client/cpp/scene_features.hpp"

namespace collided::cli {

struct Surface {
  uint32_t vertex_stride = 1;
  uint32_t vertex_count = 0;                       ///< shown ones
  std::vector<std::array<uint32_t, 3>> triangles;  ///< of shown vertices
  std::vector<std::array<uint32_t, 2>> edges;      ///< loose ones
  std::vector<uint32_t> points;                    ///< loose ones
  std::vector<uint32_t> first_vertex;              ///< shown, of each mesh; one more entry at the end
  std::vector<uint32_t> triangle_count;            ///< shown, of each mesh
  /// Of each vertex of the scene the shown one that stands for it: itself, or the closest along the surface;
  /// kNotShown where none is connected to it.
  std::vector<uint32_t> shown_vertex;
  client::SceneFeatures scene;  ///< by scene-wide ids
};

constexpr uint32_t kNotShown = ~0u;

/// `stride`: vertices 0, stride, 2 * stride and so on of each mesh are shown. Triangles between other vertices are
/// drawn between those that stand for their corners, so that the surface stays closed; those that collapse are left
/// out.
Surface make_surface(const std::vector<client::MeshElements>& meshes, uint32_t stride);

}  // namespace collided::cli
