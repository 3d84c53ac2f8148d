#pragma once
// Which meshes bound a volume, and the check that they can.

#include <string>
#include <vector>

#include "gpu/types.hpp"

namespace collided {

/// Returns the meshes that are solid, ascending.
std::vector<uint32_t> solid_meshes(const SceneSpec& spec);

/// Throws InvalidInput for a mesh that has loose elements, an edge that is not used as often in one direction as in the
/// other, or a triangle whose reverse it has as well. `field` names the mesh. Its elements have passed make_features().
/// Takes the time of sorting the triangles' edges. The volume is for volumes.hpp to check.
void check_solid(const MeshSpec& mesh, const std::string& field);

}  // namespace collided
