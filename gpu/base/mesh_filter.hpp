#pragma once
// Which triangles may touch at all, by the meshes they belong to. Null where every pair may.

#include "gpu/base/key_set.hpp"
#include "gpu/base/keys.hpp"
#include "gpu/base/vec3.hpp"

namespace collided {

struct MeshRule {
  uint32_t groups, collide_mask;          ///< of pairs with other meshes
  uint32_t is_static, has_self_contacts;  ///< 0 or 1
};

struct PairFilter {
  const uint32_t* mesh_of_triangle = nullptr;
  const MeshRule* rules = nullptr;
  KeySet excluded = {};  ///< pairs of two meshes, the lower one first (pack_ids)

  COLLIDED_HD bool is_needed() const { return mesh_of_triangle != nullptr; }
  COLLIDED_HD bool operator()(uint32_t a, uint32_t b) const {
    if (!is_needed()) return true;
    const uint32_t mesh_a = mesh_of_triangle[a], mesh_b = mesh_of_triangle[b];
    const MeshRule p = rules[mesh_a], q = rules[mesh_b];
    if (p.is_static != 0 && q.is_static != 0) return false;
    if (mesh_a == mesh_b) return p.has_self_contacts != 0;
    if ((p.groups & q.collide_mask) == 0 || (q.groups & p.collide_mask) == 0) return false;
    return !excluded.has(pack_ids(min(mesh_a, mesh_b), max(mesh_a, mesh_b)));
  }
};

}  // namespace collided
