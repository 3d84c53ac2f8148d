#pragma once
// How far vertices may be from the straight paths of a step: rigid meshes that turn move along arcs.

#include "gpu/base/precision.hpp"
#include "gpu/base/vec3.hpp"

namespace collided {

/// Returns the mesh of a vertex. `first_vertex`: of each mesh, ascending.
COLLIDED_HD inline uint32_t mesh_at(const uint32_t* first_vertex, uint32_t meshes, uint32_t vertex) {
  uint32_t low = 0, high = meshes;
  while (high - low > 1) {
    const uint32_t middle = (low + high) / 2;
    (first_vertex[middle] <= vertex ? low : high) = middle;
  }
  return low;
}

/// Which mesh a vertex is of, counted through all worlds.
struct MeshesOfVertices {
  const uint32_t* first_vertex = nullptr;  ///< of each mesh of one world
  uint32_t meshes = 0;
  uint32_t of_world = 0;  ///< vertices of each world

  COLLIDED_HD uint32_t operator[](uint32_t vertex) const {
    const uint32_t world = vertex / of_world;
    return world * meshes + mesh_at(first_vertex, meshes, vertex - world * of_world);
  }
};

/// By mesh. None where no mesh can turn.
struct Deviations {
  const uint32_t* first_vertex = nullptr;  ///< of each mesh
  const double* of_mesh = nullptr;         ///< >= 0, and after the last mesh's the largest of them
  uint32_t meshes = 0;
  double times = 1;  ///< a factor on all deviations

  /// Returns deviations that hold for each part of the step's ways that begins where the step does.
  COLLIDED_HD Deviations of_parts() const { return {first_vertex, of_mesh, meshes, kOfParts * times}; }
  static constexpr double kOfParts = 4;

  COLLIDED_HD bool is_needed() const { return meshes != 0; }
  /// Of a mesh's vertices, which it is enough to name one of.
  COLLIDED_HD double of(uint32_t vertex) const { return times * of_mesh[mesh_at(first_vertex, meshes, vertex)]; }
  /// What two features may be closer to each other than their straight paths are, at most. They are told by a vertex of
  /// each.
  COLLIDED_HD double of_pair(uint32_t first, uint32_t second) const {
    return is_needed() ? widened(of(first), of(second)) : 0;
  }
  COLLIDED_HD double of_any_pair() const { return is_needed() ? 2 * times * of_mesh[meshes] : 0; }
  /// `inflation` of the boxes of a mesh, rounded up.
  template <class Real>
  COLLIDED_HD Real inflation(Real inflation, uint32_t vertex) const {
    if (!is_needed()) return inflation;
    const double deviation = of(vertex);
    return deviation > 0 ? next_up(inflation + round_up<Real>(deviation)) : inflation;
  }

  /// a + b, rounded up; exact where one of them is 0.
  COLLIDED_HD static double widened(double a, double b) { return sum_above(a, b); }
};

}  // namespace collided
