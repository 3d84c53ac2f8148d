#pragma once
// In which branch of the hierarchy (engines/lbvh/lbvh.hpp) each mesh is, where rules keep most pairs apart.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gpu/base/mesh_filter.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Classes of meshes that rules treat alike are all compared with each other; more of them are left as they are.
inline constexpr size_t kMaxRuleClasses = 1024;

/// Returns the branch of each mesh, or nothing where branches do not pay. They pay where at most an eighth of all pairs
/// may touch, or where at most 16 branches keep a 64th of all pairs apart and a mesh of each pair moves. Meshes share a
/// branch if they have the same groups and mask and agree on whether they touch themselves. A mesh has its own branch
/// if exclusions keep it from most of these, or if it is large and may not touch itself. Vertices stand for triangles,
/// whose number may come after the spec.
std::vector<uint32_t> branches_of(const SceneSpec& spec, const std::vector<MeshRule>& rules);

}  // namespace collided
