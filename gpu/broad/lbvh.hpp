#pragma once
// A linear bounding volume hierarchy over the triangles' boxes, the yardstick of the octree: leaves in Morton order
// (Karras 2012), ranges and boxes in one pass from the leaves up (Apetrei 2014), ropes instead of a stack for the walk
// (Prokopenko and Lebrun-Grandie 2024).
// - Nodes [0, n - 1) are internal, node n - 1 + i is the i-th leaf in Morton order. A left child of a split between
//   leaves s and s + 1 is internal node s, a right child s + 1: no two have the same number, and the root has 0.
// - A node's rope leads to the first node of the depth-first order that is not below it. A walk that starts at a leaf's
//   rope therefore meets later leaves alone: each pair once.
// - Triangles much larger than most have the last places: as leaves among the others they would blow up all nodes
//   above them, and one thread would have to meet all their partners. There, their partners meet them.

#include "gpu/broad/pair_filter.hpp"
#include "gpu/exec/atomic.hpp"
#include "gpu/math/extent.hpp"
#include "gpu/math/lattice.hpp"

namespace collided {

/// 32 bytes: two loads.
struct alignas(16) BvhNode {
  Vec3<float> lo;
  uint32_t child;  ///< the left one; of a leaf: its triangle
  Vec3<float> hi;
  uint32_t rope;

  COLLIDED_HD Box<float> box() const { return {lo, hi}; }
};
static_assert(sizeof(BvhNode) == 32);

/// End of a walk.
constexpr uint32_t kNoNode = ~0u;

/// What the leaves are sorted by: whether the triangle is large, then the Morton code of its box's centre.
struct MortonKeys {
  static constexpr int kAxisBits = 15;
  static constexpr int kBits = 3 * kAxisBits + 1;
  static constexpr uint64_t kMuchLarger = 16;  ///< times the mean

  const Box<float>* bounds;
  MeanExtent mean;
  Span<const Box<float>> boxes;
  Span<uint64_t> keys;
  Span<uint32_t> triangles, meeting;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Box<float> box = boxes[i];
    const Coords c = shifted(grid_over(*bounds, 0, 0).deepest_cell(centre(box)), kDeepest - kAxisBits);
    const uint64_t large = mean.is_exceeded(box, kMuchLarger) ? 1 : 0;
    keys[i] = large << (3 * kAxisBits) | long_morton(c);
    triangles[i] = static_cast<uint32_t>(i);
    meeting[i] = kNoNode;
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

/// Where the hierarchy splits, by the sorted keys alone. Equal keys are told apart by their places.
struct BvhSplits {
  Span<const uint64_t> keys;
  uint32_t leaves;

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
  COLLIDED_HD uint32_t leaf(uint32_t i) const { return leaves - 1 + i; }
  COLLIDED_HD uint32_t left_child(uint32_t first, uint32_t split) const { return first == split ? leaf(first) : split; }
  COLLIDED_HD uint32_t right_child(uint32_t split, uint32_t last) const {
    return split + 1 == last ? leaf(last) : split + 1;
  }
  /// Of a node that ends with leaf `last`: the right child of the split behind it.
  COLLIDED_HD uint32_t rope(uint32_t last) const {
    const uint32_t next = last + 1;
    if (next >= leaves) return kNoNode;
    return next + 1 == leaves || is_closer(last, next) ? leaf(next) : next;
  }
};

/// Goes up from each leaf. Of the two that meet at a split the first leaves; the second knows the whole node.
struct BuildHierarchy {
  BvhSplits splits;
  Span<const uint32_t> triangles;  ///< in order of the leaves
  Span<const Box<float>> boxes;
  Span<uint32_t> meeting;  ///< of each split: kNoNode, then the far end of the child that came first
  Span<BvhNode> nodes;

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint32_t leaf = static_cast<uint32_t>(i), triangle = triangles[i];
    uint32_t first = leaf, last = leaf;
    Box<float> box = boxes[triangle];
    put(splits.leaf(leaf), box, triangle, last);
    while (last - first + 1 < splits.leaves) {
      const bool left = splits.is_left(first, last);
      const uint32_t split = left ? last : first - 1;
      const uint32_t other = exchange_in_order(meeting[split], left ? first : last);
      if (other == kNoNode) return;
      const uint32_t sibling = left ? splits.right_child(split, other) : splits.left_child(other, split);
      (left ? last : first) = other;
      box = join(box, nodes[sibling].box());
      const bool is_root = last - first + 1 == splits.leaves;
      put(is_root ? 0 : splits.is_left(first, last) ? last : first, box, splits.left_child(first, split), last);
    }
  }

 private:
  COLLIDED_HD void put(uint32_t node, const Box<float>& box, uint32_t child, uint32_t last) const {
    nodes[node] = {box.lo, child, box.hi, splits.rope(last)};
  }
};

/// A source of pairs: the walks of all leaves through the hierarchy.
struct BvhPairs {
  Span<const BvhNode> nodes;
  uint32_t leaves;
  PairFilter filter;
  uint64_t* tests;  ///< boxes met; null: counted by another search

  /// One leaf on its way.
  struct Walk {
    Box<float> box{};
    uint32_t triangle = 0, found = 0;
    uint32_t node = kNoNode;  ///< the next to be met

    COLLIDED_HD bool is_over() const { return node == kNoNode; }
  };
  COLLIDED_HD Walk walk(uint64_t i) const {
    const BvhNode leaf = nodes[leaves - 1 + i];
    return {leaf.box(), leaf.child, 0, leaf.rope};
  }
  /// Meets the next node; whether that is a partner, which `found` then names.
  COLLIDED_HD bool step(Walk& walk) const {
    const bool is_leaf = walk.node >= leaves - 1;
    const BvhNode node = nodes[walk.node];
    const bool meets = overlap(walk.box, node.box());
    walk.node = meets && !is_leaf ? node.child : node.rope;
    walk.found = node.child;
    return meets && is_leaf && filter(walk.triangle, node.child);
  }
  COLLIDED_HD void add_tests(uint64_t count) const {
    if (tests != nullptr && count != 0) atomic_add(*tests, count);
  }
};

}  // namespace collided
