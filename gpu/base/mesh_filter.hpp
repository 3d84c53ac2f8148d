#pragma once
// Which triangles may touch at all, by the meshes they belong to. Null where every pair may.

#include "gpu/base/host_device.hpp"

namespace collided {

struct MeshRule {
  uint32_t groups, collide_mask;
  uint32_t is_static, self_contacts;
};

struct PairFilter {
  const uint32_t* mesh_of_triangle = nullptr;
  const MeshRule* rules = nullptr;

  COLLIDED_HD bool is_needed() const { return mesh_of_triangle != nullptr; }
  COLLIDED_HD bool operator()(uint32_t a, uint32_t b) const {
    if (!is_needed()) return true;
    const uint32_t mesh_a = mesh_of_triangle[a], mesh_b = mesh_of_triangle[b];
    const MeshRule p = rules[mesh_a], q = rules[mesh_b];
    if (p.is_static != 0 && q.is_static != 0) return false;
    if (mesh_a == mesh_b) return p.self_contacts != 0 && (p.groups & p.collide_mask) != 0;
    return (p.groups & q.collide_mask) != 0 && (q.groups & p.collide_mask) != 0;
  }
};

}  // namespace collided
