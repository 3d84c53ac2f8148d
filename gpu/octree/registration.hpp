#pragma once
// Section 3.3, first step: the cell-triangle pairs, grouped by leaf.
// Deviation: each leaf's place is known from the counts, so the pairs are placed at once; no radix sort.

#include "gpu/octree/top_down.hpp"

namespace collided {

/// Puts a triangle into the leaves that its box overlaps.
template <bool kHasBricks>
struct RegisterTriangles {
  Tree tree;
  Span<const Box<float>> boxes;
  Span<const Leaf> leaves;
  Span<uint32_t> cursor;
  Span<uint32_t> registered;

  COLLIDED_HD void operator()(uint64_t triangle) const {
    const CellRange deepest = tree.grid->deepest_range(boxes[triangle]);
    if (shifted(deepest, kDeepest - tree.grid->base).size() <= kManyCells)
      put(static_cast<uint32_t>(triangle), deepest, 0, 1);
  }
  COLLIDED_HD void put(uint32_t triangle, const CellRange& deepest, uint32_t rank, uint32_t threads) const {
    visit_dense_cells(*tree.grid, deepest, rank, threads, [&](uint32_t cell) { put_into(cell, triangle); });
    if constexpr (kHasBricks)
      visit_bricks(tree, deepest, tree.rounds - 1, rank, threads,
                   [&](uint32_t cell, int, int, uint32_t) { put_into(cell, triangle); });
  }

 private:
  COLLIDED_HD void put_into(uint32_t cell, uint32_t triangle) const {
    if (tree.type[cell] != kLeaf || tree.slot[cell] == kNoLeaf) return;
    const uint32_t leaf = tree.slot[cell];
    registered[leaves[leaf].offset + count_up(cursor[leaf])] = triangle;
  }
};

template <bool kHasBricks>
struct RegisterLarge {
  using Shared = Nothing;
  static constexpr uint32_t kGroupSize = 32;
  RegisterTriangles<kHasBricks> registration;
  Span<const uint32_t> large;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Nothing&) const {
    const uint32_t triangle = large[i];
    registration.put(triangle, registration.tree.grid->deepest_range(registration.boxes[triangle]), group.rank,
                     group.size);
  }
};

}  // namespace collided
