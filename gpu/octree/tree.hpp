#pragma once
// What the stages of the octree grid share: per-cell arrays, bricks, and the walk over the cells that a box covers.

#include "gpu/exec/atomic.hpp"
#include "gpu/exec/counted.hpp"
#include "gpu/math/lattice.hpp"

namespace collided {

/// Cells without triangles are inactive. kRefined is an internal cell whose children are those of a brick.
enum CellType : uint8_t { kInactive = 0, kInternal = 1, kLeaf = 2, kRefined = 3 };

constexpr uint32_t kNoLeaf = ~0u;

/// The next kBrickLevels levels below a crowded cell.
struct Brick {
  uint32_t parent;  ///< index of the cell
  int level;        ///< of that cell
  Coords cell;
};

struct Tree {
  const LevelGrid* grid;
  Span<uint32_t> counts;  ///< triangles that overlap a cell; dense cells, then those of the bricks
  Span<uint8_t> type;     ///< CellType
  Span<uint32_t> slot;    ///< kLeaf: the leaf's number, or kNoLeaf; kRefined: the brick's number
  Span<Brick> bricks;
  Span<uint32_t> reach;      ///< of each brick: how many of its bottom cells its triangles overlap, added up
  Span<float> brick_cost;    ///< of the best cut below each brick's root
  uint64_t* brick_counters;  ///< bricks of each round
  int rounds;                ///< of refinement

  COLLIDED_HD bool has_brick(uint32_t cell) const { return rounds > 0 && type[cell] == kRefined; }
  /// First brick of a round; of round `rounds`: the number of all.
  COLLIDED_HD uint64_t first_brick(int round) const {
    uint64_t first = 0;
    for (int r = 0; r < round; ++r) first += brick_counters[r];
    return first < bricks.size() ? first : bricks.size();
  }
};

/// What of a range lies below a cell, `depth` levels down.
COLLIDED_HD inline CellRange clipped(const CellRange& range, const Coords& cell, int depth) {
  const uint32_t last = (1u << depth) - 1u;
  const Coords lo{cell.x << depth, cell.y << depth, cell.z << depth};
  return {{larger(range.lo.x, lo.x), larger(range.lo.y, lo.y), larger(range.lo.z, lo.z)},
          {smaller(range.hi.x, lo.x + last), smaller(range.hi.y, lo.y + last), smaller(range.hi.z, lo.z + last)}};
}

/// visit(index of the cell, round of its brick, depth below the brick's root, brick) for the cells of a brick, and of
/// the bricks below it, that a box covers.
template <int kRound, class Visit>
COLLIDED_HD void visit_brick(const Tree& tree, const CellRange& deepest, uint32_t brick, int last_round,
                             const Visit& visit) {
  const Brick root = tree.bricks[brick];
  for (int depth = 1; depth <= kBrickLevels; ++depth) {
    const CellRange range = clipped(shifted(deepest, kDeepest - root.level - depth), root.cell, depth);
    const uint32_t mask = (1u << depth) - 1u;
    for_each_cell(range, 0, 1, [&](const Coords& c) {
      const uint32_t number = level_offset(depth) + morton({c.x & mask, c.y & mask, c.z & mask});
      const uint32_t cell = brick_cell(brick, number);
      visit(cell, kRound, depth, brick);
      if constexpr (kRound + 1 < kMaxRounds) {
        if (depth == kBrickLevels && kRound < last_round && tree.type[cell] == kRefined)
          visit_brick<kRound + 1>(tree, deepest, tree.slot[cell], last_round, visit);
      }
    });
  }
}

/// visit as above for the cells of all bricks, down to those of `last_round`, that a box covers.
template <class Visit>
COLLIDED_HD void visit_bricks(const Tree& tree, const CellRange& deepest, int last_round, uint32_t rank,
                              uint32_t threads, const Visit& visit) {
  const LevelGrid grid = *tree.grid;
  for_each_cell(shifted(deepest, kDeepest - grid.base), rank, threads, [&](const Coords& c) {
    const uint32_t cell = cell_id(grid.base, c);
    if (tree.type[cell] == kRefined) visit_brick<0>(tree, deepest, tree.slot[cell], last_round, visit);
  });
}

/// visit(index of the cell) for the dense cells of a level that a box covers.
template <class Visit>
COLLIDED_HD void visit_cells_of_level(int level, const CellRange& deepest, uint32_t rank, uint32_t threads,
                                      const Visit& visit) {
  for_each_cell(shifted(deepest, kDeepest - level), rank, threads, [&](const Coords& c) { visit(cell_id(level, c)); });
}
/// The same for all active levels.
template <class Visit>
COLLIDED_HD void visit_dense_cells(const LevelGrid& grid, const CellRange& deepest, uint32_t rank, uint32_t threads,
                                   const Visit& visit) {
  for (int level = grid.top; level <= grid.base; ++level) visit_cells_of_level(level, deepest, rank, threads, visit);
}

/// Work on each triangle at each level: neighbouring items are neighbouring triangles at one level.
struct TriangleAtLevel {
  uint32_t triangle;
  int level;  ///< above the base level: nothing to do

  COLLIDED_HD TriangleAtLevel(const LevelGrid& grid, uint64_t item, uint64_t triangles)
      : triangle(static_cast<uint32_t>(item) % static_cast<uint32_t>(triangles)),
        level(grid.top + static_cast<int>(static_cast<uint32_t>(item) / static_cast<uint32_t>(triangles))) {}
};

}  // namespace collided
