#pragma once
// Section 3.3: box tests between the triangles of a leaf, as balanced items of tiles (base/tiles.hpp).
// Token rule: of the leaves that both triangles are in, only the one that holds the larger of the lower corners
// reports the pair; over any partition into leaves that is exactly one (reference point method).

#include "gpu/base/lattice.hpp"
#include "gpu/base/mesh_filter.hpp"
#include "gpu/base/tiles.hpp"
#include "gpu/engines/octree/control_bits.hpp"
#include "gpu/engines/octree/count.hpp"

namespace collided {

/// Tests for each triangle that are never reached; times 2^32 triangles they still are a number.
constexpr uint64_t kAnyNumberOfTests = uint64_t{1} << 31;

/// A source of pairs: members of leaves whose boxes overlap.
struct LeafPairs {
  const LevelGrid* grid;
  PairFilter filter;
  Span<const Box<float>> boxes;
  Span<const Leaf> leaves;
  Span<const uint32_t> registered;
  Span<const PairItem> items;
  const LeafTotals* totals;
  uint64_t registration_capacity;
  const LevelTotals* covered = nullptr;      ///< cells, by boxes; null: tests may be any number
  uint64_t max_crowded_tests = 0;            ///< for each triangle with a box; beyond this the octree is refined first
  Span<const MembersByStart> by_start = {};  ///< of each leaf, where members are in that order

  /// Whether the step will run again anyway, so that the search would be in vain: what does not fit was not written.
  COLLIDED_HD bool must_rerun() const {
    return (*totals)[LeafSum::kLeaves] > leaves.size() || (*totals)[LeafSum::kRegistrations] > registration_capacity ||
           (*totals)[LeafSum::kItems] > items.size() || is_too_crowded();
  }

  /// One item, ready to be worked on.
  struct Work {
    Leaf leaf;
    const uint32_t* members;
    uint32_t row, first_column, end_column;  ///< members
    bool is_own;                             ///< known: all pairs are the part's own (PlaceLeaves::is_others)
  };
  COLLIDED_HD Work work(uint64_t i) const {
    const PairItem item = items[i];
    const Leaf leaf = leaves[item.leaf];
    return {leaf,
            registered.data + leaf.offset,
            item.row * kTile,
            item.column * kTile,
            min((item.column + tiles_of_item(leaf.count)) * kTile, end_of_row(item, leaf)),
            filter.own.has_leaves_of_one_part(*grid, leaf.level)};
  }
  /// Bit k: whether the box starts in the leaf's cell on axis k.
  COLLIDED_HD uint32_t axes_of_start(const Work& work, const Box<float>& box) const {
    return axes_of_start(work.leaf, box);
  }
  COLLIDED_HD uint32_t axes_of_start(const Leaf& leaf, const Box<float>& box) const {
    const Coords start = shifted(grid->deepest_cell(box.lo), kDeepest - leaf.level), cell = leaf.cell;
    return (start.x == cell.x ? 1u : 0u) | (start.y == cell.y ? 2u : 0u) | (start.z == cell.z ? 4u : 0u);
  }
  /// Whether a pair whose boxes overlap is this leaf's to report: on each axis one of them starts in the cell, for
  /// neither starts behind it.
  COLLIDED_HD static bool reports(uint32_t axes_a, uint32_t axes_b) { return (axes_a | axes_b) == 7u; }

 private:
  COLLIDED_HD bool is_too_crowded() const {
    return covered != nullptr && (*totals)[LeafSum::kCrowdedTests] > max_crowded_tests * covered->boxed();
  }
  /// Behind the last member that those of the item's row may report a pair with; whole tiles.
  COLLIDED_HD uint32_t end_of_row(const PairItem& item, const Leaf& leaf) const {
    if (by_start.empty()) return leaf.count;
    return min(leaf.count, tiles_of(by_start[item.leaf].end_for(item.row * kTile)) * kTile);
  }
};

}  // namespace collided
