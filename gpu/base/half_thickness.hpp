#pragma once
// Meshes may be thick by themselves, so that each pair of meshes has a contact distance of its own.

#include "gpu/base/contact_distance.hpp"
#include "gpu/base/deviations.hpp"

namespace collided {

/// The half thicknesses of two features' meshes.
struct PairHalves {
  double first, second;
};

/// The half thickness of each mesh. None where no mesh is thick, or where half thicknesses do not count.
struct HalfThicknesses {
  const uint32_t* first_vertex = nullptr;  ///< of each mesh
  const double* of_mesh = nullptr;         ///< >= 0
  uint32_t meshes = 0;
  uint32_t of_world = 0;  ///< vertices of each world, whose meshes are the same; 0: the scene is one

  COLLIDED_HD bool is_needed() const { return meshes != 0; }
  /// Returns that of a vertex' mesh.
  COLLIDED_HD double of(uint32_t vertex) const {
    return of_mesh[mesh_at(first_vertex, meshes, of_world == 0 ? vertex : vertex % of_world)];
  }
  /// Returns the distance of two features, each told by one of its vertices, in a scene of that thickness.
  COLLIDED_HD ContactDistance of_pair(double thickness, uint32_t first, uint32_t second) const {
    return is_needed() ? ContactDistance(thickness, of(first), of(second)) : ContactDistance(thickness);
  }
  /// Returns the inflation of a mesh's boxes, given that of a mesh that is not thick; rounded up.
  template <class Real>
  COLLIDED_HD Real inflation(Real inflation, uint32_t vertex) const {
    if (!is_needed()) return inflation;
    const double half = of(vertex);
    return half > 0 ? next_up(inflation + round_up<Real>(half)) : inflation;
  }
};

}  // namespace collided
