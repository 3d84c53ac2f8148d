#pragma once
// How meshes lie to each other, from what crosses, what touches, and which vertices are in which solids.

#include <array>
#include <functional>
#include <vector>

#include "gpu/contacts/solid_meshes.hpp"

namespace collided {

/// An edge and a triangle.
using EdgeAndTriangle = std::array<uint32_t, 2>;

/// What a frame has found of its solids.
struct FoundInSolids {
  const SolidMeshes& meshes;
  const ContactSet& crossings;               ///< edges that go through triangles, ties among them
  const std::vector<EdgeAndTriangle>& ties;  ///< pairs with a tie that have a point in common, crossings or not
  const ContactSet& inside;                  ///< vertices in solids, with distances
  const std::vector<uint64_t>& on;           ///< vertices on solids (pack_ids: a vertex, a solid's number)
};

/// Tells whether two meshes (first < second) that only touch overlap all the same: where all that meets is a tie, and
/// no vertex is in the other mesh.
using OverlapDecision = std::function<bool(uint32_t first, uint32_t second)>;

/// Returns the states of all pairs that are not apart, in order. `decide` is asked where the rest leaves it open.
std::vector<MeshPairState> find_pair_states(const FoundInSolids& found, const OverlapDecision& decide);

}  // namespace collided
