#pragma once
// Finds the meshes that are to bound a volume, and checks that they can.

#include <string>
#include <vector>

#include "gpu/types.hpp"

namespace collided {

/// Returns the meshes that are solid, ascending.
std::vector<uint32_t> solid_meshes(const SceneSpec& spec);

/// Throws InvalidInput for a mesh that has loose elements, an edge that is not used as often in one direction as in the
/// other, or a triangle whose reverse it has as well. `field` names the mesh. Its elements have passed make_features().
/// Takes O(n log n) time. The volume's sign is for sign_of_volume() to check.
void check_solid(const MeshSpec& mesh, const std::string& field);

}  // namespace collided
