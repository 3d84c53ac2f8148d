#pragma once
// A linear bounding volume hierarchy over the triangles' boxes, the yardstick of the octree: leaves in Morton order
// (Karras 2012), ranges and boxes in one pass from the leaves up (Apetrei 2014), ropes instead of a stack for the walk
// (Prokopenko and Lebrun-Grandie 2024).
// - Node 2s is the left child of the split between leaves s and s + 1, node 2s + 1 the right one: they lie side by
//   side, since a traversal that tests one usually tests both. The root has no number: no traversal tests it.
// - A node's rope leads to the first node of the depth-first order that is not below it, which is a right child: that
//   of the split behind the node's last leaf. A walk that starts at a leaf's rope therefore meets later leaves alone:
//   each pair once.
// - What a walk has still to do can be divided: the nodes below a node, and those from its rope on.
// - Triangles much larger than most have the last places: as leaves among the others they would blow up all nodes
//   above them, and one walk would have to meet all their partners. There, their partners meet them.
// - Where rules keep most pairs of meshes apart, a hierarchy by place alone would have every walk meet all that lies in
//   its place: 700 probes in one place, which may touch a box alone, would meet each other. There nodes know the meshes
//   below them (MeshesTogether), walks pass over those that they may not touch, and leaves are sorted by branch first:
//   meshes that keep apart from all others have one each, so that nodes are of meshes that may touch the same.
// - Each world of a set has a hierarchy of its own, a part of the same arrays: the world comes first in a leaf's key,
// no
//   node is made above a world's, and a rope that would leave a world ends the walk. So worlds that lie over each other
//   in space cost nothing.

#include <bit>

#include "gpu/base/extent.hpp"
#include "gpu/base/lattice.hpp"
#include "gpu/base/mesh_filter.hpp"
#include "gpu/base/worlds.hpp"
#include "gpu/exec/atomic.hpp"

namespace collided {

/// 32 bytes: two loads.
struct alignas(16) BvhNode {
  static constexpr uint32_t kLeaf = 1u << 31;

  Vec3<float> lo;
  uint32_t child;  ///< the left one; of a leaf: kLeaf and its triangle
  Vec3<float> hi;
  uint32_t rope;

  COLLIDED_HD Box<float> box() const { return {lo, hi}; }
  COLLIDED_HD bool is_leaf() const { return (child & kLeaf) != 0; }
  COLLIDED_HD uint32_t triangle() const { return child & ~kLeaf; }
};
static_assert(sizeof(BvhNode) == 32);

/// End of a walk.
constexpr uint32_t kNoNode = ~0u;

/// The branch of each triangle's mesh.
struct BvhBranches {
  static constexpr int kMaxBits = 16;

  PairFilter filter = {};
  int bits = 0;  ///< 0: all are in one

  COLLIDED_HD uint64_t of(uint32_t triangle) const { return bits == 0 ? 0 : filter.branch_of(triangle); }
};

/// Sort keys of the leaves: whether the triangle is large, then its branch, then the Morton code of its box's centre.
struct MortonKeys {
  static constexpr int kMaxAxisBits = 15;
  static constexpr int kBits = 3 * kMaxAxisBits + 1;
  static constexpr uint64_t kMuchLarger = 16;  ///< times the mean

  const Box<float>* bounds;
  MeanExtent mean;
  Span<const Box<float>> boxes;
  Span<uint64_t> keys;
  Span<uint32_t> triangles, meeting;
  int axis_bits = kMaxAxisBits;
  BvhBranches branches = {};

  /// A sort goes over the keys once for every eight bits. Where triangles are few, one round less is worth more than
  /// the boxes that walks then meet: no more than before in most scenes, up to 1.6 times as many where scales are
  /// mixed.
  static constexpr int axis_bits_for(uint64_t triangles) { return triangles <= (1u << 16) ? 13 : kMaxAxisBits; }
  int bits() const { return 3 * axis_bits + 1 + branches.bits; }

  COLLIDED_HD void operator()(uint64_t i) const {
    keys[i] = key_of(boxes[i], *bounds, mean, axis_bits, branches, static_cast<uint32_t>(i));
    triangles[i] = static_cast<uint32_t>(i);
    meeting[i] = kNoNode;
  }

  COLLIDED_HD static uint64_t key_of(const Box<float>& box, const Box<float>& bounds, const MeanExtent& mean,
                                     int axis_bits, const BvhBranches& branches, uint32_t triangle) {
    const uint64_t large = mean.is_exceeded(box, kMuchLarger) ? 1 : 0;
    return (large << branches.bits | branches.of(triangle)) << (3 * axis_bits) | morton_of(box, bounds, axis_bits);
  }
  /// Of the box's centre, so many bits an axis.
  COLLIDED_HD static uint64_t morton_of(const Box<float>& box, const Box<float>& bounds, int axis_bits) {
    return long_morton(shifted(grid_over(bounds, 0, 0).deepest_cell(centre(box)), kDeepest - axis_bits));
  }

 private:
  COLLIDED_HD static Vec3<float> centre(const Box<float>& b) {
    return {0.5f * b.lo.x + 0.5f * b.hi.x, 0.5f * b.lo.y + 0.5f * b.hi.y, 0.5f * b.lo.z + 0.5f * b.hi.z};
  }
  /// Of up to 20 bits an axis.
  COLLIDED_HD static uint64_t long_morton(const Coords& c) {
    constexpr uint32_t kLow = (1u << 10) - 1u;
    return uint64_t{morton(shifted(c, 10))} << 30 | morton({c.x & kLow, c.y & kLow, c.z & kLow});
  }
};

/// The same for a set of worlds: the world comes first.
struct WorldMortonKeys {
  const Box<float>* bounds;  ///< of each world
  const uint64_t* extents;   ///< likewise; their sum
  SteppedWorlds stepped;
  Span<const Box<float>> boxes;
  Span<uint64_t> keys;
  Span<uint32_t> triangles, meeting;
  int axis_bits;
  BvhBranches branches = {};

  /// Where a world is small, cells as fine as a large scene's tell no more, and the sort has fewer rounds.
  static constexpr int axis_bits_for(uint64_t triangles_of_world) {
    return triangles_of_world <= (1u << 12) ? 9 : MortonKeys::axis_bits_for(triangles_of_world);
  }
  static int bits(int axis_bits, uint32_t worlds) { return 3 * axis_bits + 1 + std::bit_width(worlds - 1); }

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint32_t triangle = static_cast<uint32_t>(i), world = triangle / stepped.triangles;
    const MeanExtent mean{bounds + world, extents + world, stepped.triangles};
    const uint64_t in_world =
        stepped.has(i) ? MortonKeys::key_of(boxes[i], bounds[world], mean, axis_bits, branches, triangle) : 0;
    keys[i] = uint64_t{world} << (3 * axis_bits + 1 + branches.bits) | in_world;
    triangles[i] = triangle;
    meeting[i] = kNoNode;
  }
};

/// Where the hierarchy splits, by the sorted keys alone. Equal keys are told apart by their places.
struct BvhSplits {
  Span<const uint64_t> keys;
  uint32_t leaves;
  uint32_t of_world = 0;  ///< leaves of each world, which has a hierarchy of its own; 0: there is one

  COLLIDED_HD uint32_t leaves_of_root() const { return of_world == 0 ? leaves : of_world; }
  /// Whether no leaf of the same hierarchy comes after this one.
  COLLIDED_HD bool is_last(uint32_t leaf) const {
    return of_world == 0 ? leaf + 1 == leaves : (leaf + 1) % of_world == 0;
  }

  /// Whether leaves a and a + 1 are closer to each other than b and b + 1; never equally close if the leaves between
  /// them are a node's.
  COLLIDED_HD bool is_closer(uint32_t a, uint32_t b) const {
    const uint64_t at_a = keys[a] ^ keys[a + 1], at_b = keys[b] ^ keys[b + 1];
    return at_a != at_b ? at_a < at_b : (a ^ (a + 1)) < (b ^ (b + 1));
  }
  /// Whether the node of leaves [first, last], not the root, is its parent's left child.
  COLLIDED_HD bool is_left(uint32_t first, uint32_t last) const {
    return first == 0 || (last + 1 < leaves && is_closer(last, first - 1));
  }
  /// Of a node that ends with leaf `last`.
  COLLIDED_HD uint32_t rope(uint32_t last) const { return is_last(last) ? kNoNode : 2 * last + 1; }
};

/// Goes up from each leaf. Of the two that meet at a split the first leaves; the second knows the whole node.
struct BuildHierarchy {
  BvhSplits splits;
  Span<const uint32_t> triangles;  ///< in order of the leaves
  Span<const Box<float>> boxes;
  Span<uint32_t> meeting;  ///< of each split: kNoNode, then the far end of the child that came first
  Span<BvhNode> nodes;
  PairFilter filter = {};
  Span<MeshesTogether> meshes = {};  ///< below each node; empty: not needed
  uint32_t* top = nullptr;           ///< where the root's left child goes; null: nobody asks

  COLLIDED_HD void operator()(uint64_t i) const {
    uint32_t first = static_cast<uint32_t>(i), last = first, child = BvhNode::kLeaf | triangles[i];
    Box<float> box = boxes[triangles[i]];
    MeshesTogether below;
    if (!meshes.empty()) below = filter.meshes_of(triangles[i]);
    while (last - first + 1 < splits.leaves_of_root()) {
      const bool left = splits.is_left(first, last);
      const uint32_t split = left ? last : first - 1, node = 2 * split + (left ? 0 : 1);
      nodes[node] = {box.lo, child, box.hi, splits.rope(last)};
      if (!meshes.empty()) meshes[node] = below;
      const uint32_t other = exchange_in_order(meeting[split], left ? first : last);
      if (other == kNoNode) return;
      (left ? last : first) = other;
      box = join(box, nodes[node ^ 1u].box());
      if (!meshes.empty()) below.add(meshes[node ^ 1u]);
      child = 2 * split;
    }
    if (top != nullptr) *top = child;
  }
};

/// A source of pairs: the walks of all leaves through the hierarchy.
struct BvhPairs {
  Span<const BvhNode> nodes;
  uint32_t leaves;
  PairFilter filter;
  uint64_t* tests;                         ///< boxes met; null: counted by another search
  uint32_t of_world = 0;                   ///< as in BvhSplits
  Span<const MeshesTogether> meshes = {};  ///< as in BuildHierarchy

  /// One leaf on its way, or a part of that way.
  struct Walk {
    Box<float> box{};
    uint32_t triangle = 0, found = 0;
    uint32_t leaf = kNoNode;  ///< its node
    uint32_t node = kNoNode;  ///< the next to be met

    COLLIDED_HD bool is_over() const { return node == kNoNode; }
  };
  COLLIDED_HD Walk walk(uint64_t i) const {
    const uint32_t leaf = static_cast<uint32_t>(i);
    if (BvhSplits{{}, leaves, of_world}.is_last(leaf)) return {};
    return resume({nodes[2 * leaf].is_leaf() ? 2 * leaf : 2 * leaf - 1, 2 * leaf + 1});
  }
  /// Meets the next node; whether that is a partner, which `found` then names.
  COLLIDED_HD bool step(Walk& walk) const {
    const BvhNode node = nodes[walk.node];
    const bool meets = overlap(walk.box, node.box());
    walk.node = meets && goes_below(walk, walk.node, node) ? node.child : node.rope;
    walk.found = node.triangle();
    return meets && node.is_leaf() && filter(walk.triangle, walk.found);
  }

  // The same in parts that several lanes can do. A part begins at a left child and ends with what is below the right
  // one, or it begins at a right child and goes on to the end of the walk.

  struct alignas(8) Part {
    uint32_t leaf, node;
  };
  COLLIDED_HD Walk resume(const Part& part) const {
    const BvhNode leaf = nodes[part.leaf];
    return {leaf.box(), leaf.triangle(), 0, part.leaf, part.node};
  }

  /// What a part met: partners, and where else it has to go on.
  struct Met {
    uint32_t found[2] = {0, 0};
    uint32_t partners = 0;  ///< a bit for each of them
    uint32_t other = kNoNode, tests = 0;

    COLLIDED_HD bool has_other() const { return other != kNoNode; }
  };
  /// Meets both children of a split, or the right one alone. The walk goes on with what is deepest.
  COLLIDED_HD Met meet(Walk& walk) const {
    const bool only_right = is_right(walk.node);
    const BvhNode left = nodes[walk.node & ~1u], right = nodes[walk.node | 1u];
    const bool meets_left = !only_right && overlap(walk.box, left.box()), meets_right = overlap(walk.box, right.box());
    const uint32_t below_left = meets_left && goes_below(walk, walk.node & ~1u, left) ? left.child : kNoNode;
    const uint32_t below_right = meets_right && goes_below(walk, walk.node | 1u, right) ? right.child : kNoNode;
    const uint32_t deep = only_right ? below_right : below_left, late = only_right ? right.rope : below_right;
    walk.node = deep != kNoNode ? deep : late;
    return {{left.triangle(), right.triangle()},
            (is_partner(walk, meets_left, left) ? 1u : 0u) | (is_partner(walk, meets_right, right) ? 2u : 0u),
            deep != kNoNode ? late : kNoNode,
            only_right ? 1u : 2u};
  }
  /// A step of the walk.
  COLLIDED_HD Met meet_one(Walk& walk) const {
    const bool is_partner = step(walk);
    return {{walk.found, 0}, is_partner ? 1u : 0u, kNoNode, 1};
  }
  /// What is below the nodes that a walk is to meet next: steps lead to its end; then the walk goes on elsewhere.
  struct Stretch {
    uint32_t end = kNoNode, then = kNoNode;
  };
  COLLIDED_HD Stretch stretch(const Walk& walk) const {
    if (walk.is_over()) return {};
    const uint32_t end = nodes[walk.node | 1u].rope;
    return {end, is_right(walk.node) ? end : kNoNode};
  }

  COLLIDED_HD void add_tests(uint64_t count) const {
    if (tests != nullptr && count != 0) atomic_add(*tests, count);
  }

 private:
  COLLIDED_HD static bool is_right(uint32_t node) { return (node & 1u) != 0; }
  /// Of a node that the walk meets. A leaf is asked of the filter alone.
  COLLIDED_HD bool goes_below(const Walk& walk, uint32_t number, const BvhNode& node) const {
    return !node.is_leaf() && (meshes.empty() || filter.may_pass(meshes[walk.leaf], meshes[number]));
  }
  COLLIDED_HD bool is_partner(const Walk& walk, bool meets, const BvhNode& node) const {
    return meets && node.is_leaf() && filter(walk.triangle, node.triangle());
  }
};

}  // namespace collided
