#pragma once
// Which meshes of a scene may touch which, from its spec.

#include <array>
#include <optional>
#include <vector>

#include "gpu/base/mesh_filter.hpp"
#include "gpu/types.hpp"

namespace collided {

/// The rule of each mesh.
std::vector<MeshRule> mesh_rules(const SceneSpec& spec);
/// Branches of the hierarchy that they put the meshes in; 0 where most pairs may touch.
uint32_t count_branches(const SceneSpec& spec);
/// The same for the step that finds rest pairs: nothing touches but those of `meshes` that exclude such pairs,
/// themselves.
std::vector<MeshRule> rest_rules(const SceneSpec& spec, const std::vector<bool>& meshes);
/// Whether, by such rules, a mesh may touch itself.
bool may_touch(const std::vector<MeshRule>& rest_rules);

/// Meshes that may touch nothing.
IdleMeshes idle_meshes(const SceneSpec& spec);

/// Returns two of the meshes marked in `among` whose features are tested against each other, a mesh and itself
/// included.
std::optional<std::array<uint32_t, 2>> find_tested_pair(const SceneSpec& spec, const std::vector<bool>& among);

/// Whether some pair of triangles may not touch because of its meshes.
bool needs_pair_filter(const SceneSpec& spec);
/// Whether some mesh that may touch itself excludes rest pairs.
bool excludes_rest_pairs(const SceneSpec& spec);

/// Slots of PairFilter::excluded; none if no two meshes are excluded.
std::vector<uint64_t> excluded_mesh_slots(const SceneSpec& spec);

}  // namespace collided
