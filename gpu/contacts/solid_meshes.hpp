#pragma once
// What a scene that has solids knows of its meshes: on the host, and as tables of the backend.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "gpu/base/vec3.hpp"
#include "gpu/types.hpp"

namespace collided {

/// A triangle of a solid.
struct SolidTriangle {
  Vec3<uint32_t> corners;  ///< scene-wide
  uint32_t mesh, solid;    ///< `solid`: counted among the solids, in the order of meshes
  uint32_t id;             ///< scene-wide
};

/// A vertex that may be in a solid.
struct MeshVertex {
  static constexpr uint32_t kNoSolid = ~0u;

  uint32_t vertex, mesh;
  uint32_t solid;  ///< that the mesh is; kNoSolid
};

/// The host's part. Empty where nobody asks what is in solids.
struct SolidMeshes {
  const Topology* topology = nullptr;  ///< of the scene
  std::vector<bool> are_solid;         ///< of each mesh
  std::vector<uint32_t> solids;        ///< their meshes, ascending
  std::vector<uint32_t> used;          ///< vertices of each mesh that an element has
  std::vector<uint32_t> edge_offset;   ///< of each mesh's edges; one more entry at the end

  uint32_t mesh_of_vertex(uint32_t vertex) const { return at(topology->vertex_offset, vertex); }
  uint32_t mesh_of_triangle(uint32_t triangle) const { return at(topology->triangle_offset, triangle); }
  uint32_t mesh_of_edge(uint32_t edge) const { return at(edge_offset, edge); }

 private:
  static uint32_t at(const std::vector<uint32_t>& offsets, uint32_t id) {
    return static_cast<uint32_t>(std::upper_bound(offsets.begin(), offsets.end(), id) - offsets.begin()) - 1;
  }
};

/// What goes to the backend.
struct SolidTables {
  SolidMeshes meshes;
  std::vector<SolidTriangle> triangles;  ///< of all solids, ascending
  std::vector<uint32_t> first_places;    ///< of each solid's triangles among them
  std::vector<MeshVertex> vertices;  ///< that an element of a mesh has which may touch another one's solid, ascending
};

}  // namespace collided
