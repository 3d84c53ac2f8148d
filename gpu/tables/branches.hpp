#pragma once
// In which branch of the hierarchy (lbvh/lbvh.hpp) each mesh is, where rules keep most pairs apart.

#include <cstdint>
#include <vector>

#include "gpu/base/mesh_filter.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Returns the branch of each mesh; none where more than an eighth of all pairs may touch, for there branches gain
/// nothing. Meshes of the same groups and mask share one, since groups and masks treat them alike. A mesh that
/// exclusions keep from most of these has its own. Vertices stand for triangles, whose number may come after the spec.
std::vector<uint32_t> branches_of(const SceneSpec& spec, const std::vector<MeshRule>& rules);

}  // namespace collided
