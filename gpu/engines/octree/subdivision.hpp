#pragma once
// A uniform grid with virtual subdivision (Wong, Leach and Zambetta 2012), as we read it: cells are as large as
// ordinary triangles, however large others are; a large one is cut, and each piece is registered by itself; control
// bits see to it that a pair is tested in one cell alone. Pairs are those of boxes, so that it is a triangle's box that
// is cut, and it is cut where cells end: a piece lies in one cell and is registered once. The cell of the larger of two
// lower corners holds a piece of either box.

#include "gpu/base/extent.hpp"
#include "gpu/engines/octree/bottom_up.hpp"
#include "gpu/engines/octree/leaf_pairs.hpp"

namespace collided {

/// Of triangles that are not large: the sum of their extents, in units as extent_of()'s, and how many they are.
struct OrdinaryExtents {
  uint64_t sum, count;
};
struct OrdinaryExtentOf {
  /// Triangles larger than so many means are large.
  static constexpr uint64_t kLarge = 2;
  MeanExtent mean;
  Span<const Box<float>> boxes;

  COLLIDED_HD OrdinaryExtents operator()(uint64_t i) const {
    if (is_no_box(boxes[i]) || mean.is_exceeded(boxes[i], kLarge)) return {0, 0};
    return {extent_of(boxes[i], *mean.bounds), 1};
  }
};
struct AddOrdinaryExtents {
  COLLIDED_HD OrdinaryExtents operator()(const OrdinaryExtents& a, const OrdinaryExtents& b) const {
    return {a.sum + b.sum, a.count + b.count};
  }
};

/// The mean of ordinary triangles' extents. There are some, not all triangles are larger than the mean; but a part of a
/// scene may have none.
struct OrdinaryMean {
  const Box<float>* bounds;
  const OrdinaryExtents* ordinary;

  COLLIDED_HD double operator()() const {
    return ordinary->count == 0 ? 0 : MeanExtent{bounds, &ordinary->sum, ordinary->count}();
  }
};

/// Puts the members of each leaf in the order of their control bits.
struct OrderByControlBits {
  struct Shared {
    uint32_t count[MembersByStart::kPlaces];  ///< of members; then the next place
  };
  static constexpr uint32_t kGroupSize = 32;
  LeafPairs pairs;
  Span<uint32_t> ordered;        ///< as LeafPairs::registered
  Span<MembersByStart> members;  ///< of each leaf
  LeafTotals* totals;            ///< tests that the bits save are taken off

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Shared& shared) const {
    if (pairs.must_rerun()) return;
    const Leaf leaf = pairs.leaves[i];
    for (uint32_t k = group.rank; k < MembersByStart::kPlaces; k += group.size) shared.count[k] = 0;
    group.sync();
    for (uint32_t k = group.rank; k < leaf.count; k += group.size)
      atomic_add(shared.count[place_of(leaf, registered(leaf, k))], 1u);
    group.sync();
    if (group.rank == 0) claim(i, leaf, shared);
    group.sync();
    for (uint32_t k = group.rank; k < leaf.count; k += group.size) {
      const uint32_t triangle = registered(leaf, k);
      ordered[leaf.offset + atomic_add(shared.count[place_of(leaf, triangle)], 1u)] = triangle;
    }
    group.sync();
  }

 private:
  COLLIDED_HD uint32_t registered(const Leaf& leaf, uint32_t k) const { return pairs.registered[leaf.offset + k]; }
  COLLIDED_HD uint32_t place_of(const Leaf& leaf, uint32_t triangle) const {
    return MembersByStart::place_of(pairs.axes_of_start(leaf, pairs.boxes[triangle]));
  }
  COLLIDED_HD void claim(uint64_t i, const Leaf& leaf, Shared& shared) const {
    MembersByStart made;
    uint32_t sum = 0;
    for (uint32_t place = 0; place < MembersByStart::kPlaces; ++place) {
      const uint32_t count = shared.count[place];
      shared.count[place] = sum;
      made.end[place] = sum += count;
    }
    members[i] = made;
    atomic_add((*totals)[LeafSum::kTests], made.tests() - tests_of(leaf.count));
  }
};

}  // namespace collided
