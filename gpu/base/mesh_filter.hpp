#pragma once
// Which triangles may touch at all, by the meshes they belong to (null where every pair may); in a part of a scene, of
// the pairs that are its own.

#include <vector>

#include "gpu/base/key_set.hpp"
#include "gpu/base/keys.hpp"
#include "gpu/base/share.hpp"

namespace collided {

struct MeshRule {
  uint32_t groups, collide_mask;          ///< of pairs with other meshes
  uint32_t is_static, has_self_contacts;  ///< 0 or 1
  uint32_t branch = 0;   ///< of the hierarchy (engines/lbvh/lbvh.hpp); all 0 where most pairs may touch
  uint32_t is_idle = 0;  ///< 1: the mesh may touch nothing, itself included
};

/// True if two different meshes of these rules may touch, unless their pair is excluded.
COLLIDED_HD inline bool may_touch(const MeshRule& p, const MeshRule& q) {
  return (p.is_static == 0 || q.is_static == 0) && (p.groups & q.collide_mask) != 0 && (q.groups & p.collide_mask) != 0;
}
/// True if a mesh of this rule may touch itself.
COLLIDED_HD inline bool touches_itself(const MeshRule& p) { return p.is_static == 0 && p.has_self_contacts != 0; }

/// Meshes of a scene that may touch nothing. Their triangles take no part in a search.
struct IdleMeshes {
  std::vector<bool> meshes = {};  ///< empty: none is idle
  bool are_all = false;

  bool has_any() const { return !meshes.empty(); }
  bool has(size_t mesh) const { return has_any() && meshes[mesh]; }
};

/// What is known of the meshes of several triangles together. Of none: they touch nothing.
struct MeshesTogether {
  static constexpr uint32_t kMoves = 1, kHasSelfContacts = 2;

  uint32_t lowest = ~0u, highest = 0;
  uint32_t groups = 0, collide_masks = 0;
  uint32_t traits = 0;  ///< kMoves, kHasSelfContacts: some mesh does

  COLLIDED_HD void add(const MeshesTogether& more) {
    lowest = min(lowest, more.lowest), highest = max(highest, more.highest);
    groups |= more.groups, collide_masks |= more.collide_masks;
    traits |= more.traits;
  }
  COLLIDED_HD bool is_one() const { return lowest == highest; }
};

struct PairFilter {
  const uint32_t* mesh_of_triangle = nullptr;
  const MeshRule* rules = nullptr;
  KeySet excluded = {};   ///< pairs of two meshes, the lower one first (pack_ids)
  uint32_t of_world = 0;  ///< triangles of each world, whose meshes are the same; 0: the scene is one
  SharedPairs own = {};

  COLLIDED_HD bool has_rules() const { return mesh_of_triangle != nullptr; }
  /// Of two triangles whose boxes overlap. `is_own`: their pair is known to be the part's own.
  COLLIDED_HD bool operator()(uint32_t a, uint32_t b, bool is_own = false) const {
    return (is_own || own.has(a, b)) && may_touch(a, b);
  }
  COLLIDED_HD bool may_touch(uint32_t a, uint32_t b) const {
    return !has_rules() || may_touch_meshes(mesh_of(a), mesh_of(b));
  }
  /// Whether triangles of these meshes of a world may touch.
  COLLIDED_HD bool may_touch_meshes(uint32_t mesh_a, uint32_t mesh_b) const {
    if (!has_rules()) return true;
    const MeshRule p = rules[mesh_a], q = rules[mesh_b];
    if (mesh_a == mesh_b) return touches_itself(p);
    return collided::may_touch(p, q) && !excludes(mesh_a, mesh_b);
  }

  /// Of one triangle. Only where there are rules, like what follows.
  COLLIDED_HD MeshesTogether meshes_of(uint32_t triangle) const {
    const uint32_t mesh = mesh_of(triangle);
    const MeshRule rule = rules[mesh];
    const uint32_t moves = rule.is_static != 0 ? 0u : MeshesTogether::kMoves;
    const uint32_t has_self = rule.has_self_contacts != 0 ? MeshesTogether::kHasSelfContacts : 0u;
    return {mesh, mesh, rule.groups, rule.collide_mask, moves | has_self};
  }
  COLLIDED_HD uint32_t branch_of(uint32_t triangle) const { return rules[mesh_of(triangle)].branch; }
  COLLIDED_HD bool is_idle(uint32_t triangle) const { return rules[mesh_of(triangle)].is_idle != 0; }
  /// Whether some triangle of p and some triangle of q may pass; never false where a pair does.
  COLLIDED_HD bool may_pass(const MeshesTogether& p, const MeshesTogether& q) const {
    if (((p.traits | q.traits) & MeshesTogether::kMoves) == 0) return false;
    const bool can_share_mesh = p.lowest <= q.highest && q.lowest <= p.highest;
    if (can_share_mesh && (p.traits & q.traits & MeshesTogether::kHasSelfContacts) != 0) return true;
    const bool are_one_each = p.is_one() && q.is_one();
    if (are_one_each && p.lowest == q.lowest) return false;
    if ((p.groups & q.collide_masks) == 0 || (q.groups & p.collide_masks) == 0) return false;
    return !are_one_each || !excludes(p.lowest, q.lowest);
  }

 private:
  COLLIDED_HD uint32_t mesh_of(uint32_t triangle) const {
    return mesh_of_triangle[of_world == 0 ? triangle : triangle % of_world];
  }
  COLLIDED_HD bool excludes(uint32_t mesh, uint32_t other) const {
    return excluded.has(pack_ids(min(mesh, other), max(mesh, other)));
  }
};

}  // namespace collided
