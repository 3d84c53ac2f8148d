#pragma once
// Section 3.3, first step: the cell-triangle pairs, grouped by leaf.
// Deviation: each leaf's place is known from the counts, so the pairs are placed at once; no radix sort.

#include "gpu/octree/top_down.hpp"

namespace collided {

/// Puts triangles into the leaves that their boxes overlap; one item for each triangle and dense level.
template <bool kHasBricks>
struct RegisterTriangles {
  Tree tree;
  Span<const Box<float>> boxes;
  Span<uint32_t> cursor;  ///< next place of each leaf
  Span<uint32_t> registered;

  COLLIDED_HD void operator()(uint64_t i) const {
    const LevelGrid grid = *tree.grid;
    const TriangleAtLevel at(grid, i, boxes.size());
    if (at.level > grid.base) return;
    const CellRange deepest = grid.deepest_range(boxes[at.triangle]);
    if (shifted(deepest, kDeepest - grid.base).size() <= kManyCells) put(at.triangle, at.level, deepest, 0, 1);
  }
  COLLIDED_HD void put(uint32_t triangle, int level, const CellRange& deepest, uint32_t rank, uint32_t threads) const {
    visit_cells_of_level(level, deepest, rank, threads, [&](uint32_t cell) { put_into(cell, triangle); });
    if constexpr (kHasBricks)
      if (level == tree.grid->base)
        visit_bricks(tree, deepest, tree.rounds - 1, rank, threads,
                     [&](uint32_t cell, int, int, uint32_t) { put_into(cell, triangle); });
  }

 private:
  COLLIDED_HD void put_into(uint32_t cell, uint32_t triangle) const {
    if (tree.type[cell] != kLeaf) return;
    const uint32_t leaf = tree.slot[cell];
    if (leaf != kNoLeaf) registered[count_up(cursor[leaf])] = triangle;
  }
};

template <bool kHasBricks>
struct RegisterLarge {
  using Shared = Nothing;
  static constexpr uint32_t kGroupSize = 128;
  RegisterTriangles<kHasBricks> registration;
  Span<const uint32_t> large;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Nothing&) const {
    const LevelGrid grid = *registration.tree.grid;
    const CellRange deepest = grid.deepest_range(registration.boxes[large[i]]);
    for (int level = grid.top; level <= grid.base; ++level)
      registration.put(large[i], level, deepest, group.rank, group.size);
  }
};

}  // namespace collided
