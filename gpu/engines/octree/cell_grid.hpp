#pragma once
// Grids whose cells have a size that comes from the triangles, as the octree's predecessors have: one level of cells,
// or two, where crowded cells of the upper one are divided (Fan et al. 2011). They use the octree's arrays and stages;
// only the grid and the cut are their own.

#include "gpu/base/extent.hpp"
#include "gpu/engines/octree/levels.hpp"
#include "gpu/engines/octree/top_down.hpp"

namespace collided {

/// How many levels lie below the top of a two-level grid: a cell has 64 small ones.
constexpr int kLevelsOfCrowdedCell = 2;

/// A base level whose cells are `cell_per_mean` times smaller than the mean triangle is large, or as small as
/// `deepest` allows; all levels above are active. `mean()` is the length that it is.
template <class Mean>
struct SpanCells {
  const Box<float>* bounds;
  Mean mean;
  double cell_per_mean;
  int deepest;
  LevelGrid* grid;

  COLLIDED_HD void operator()(uint64_t) const {
    const double side = largest_side(*bounds);
    double cell = max(cell_per_mean * mean(), side / (1 << deepest));
    int base = 0;
    for (double covered = cell; covered < side && base < deepest; covered *= 2) ++base;
    *grid = grid_over(*bounds, 0, base);
    if (base > 0) grid->cells_per_length = static_cast<float>((1u << (kDeepest - base)) / cell);
  }
};

/// As CoveredPerLevel, over a grid that is there already.
struct CoveredPerLevelOf {
  const LevelGrid* grid;
  Span<const Box<float>> boxes;

  COLLIDED_HD LevelTotals operator()(uint64_t triangle) const {
    const Box<float> box = boxes[triangle];
    LevelTotals totals{};
    if (is_no_box(box)) return totals;
    const CellRange deepest = grid->deepest_range(box);
    for (int level = 0; level <= kMaxLevel; ++level) totals.cells[level] = shifted(deepest, kDeepest - level).size();
    return totals;
  }
};

/// Coarser cells, each twice as large as the last, if the registrations are too many.
struct ChooseCells {
  const LevelTotals* totals;
  int levels;  ///< 0: the base level alone
  GridState* state;

  COLLIDED_HD void operator()(uint64_t) const {
    LevelGrid grid = state->grid;
    const ActiveLevels chosen = clamp_levels({grid.base, grid.base}, *totals);
    grid.base = chosen.base;
    grid.top = chosen.base > levels ? chosen.base - levels : 0;
    *state = grid_state(grid);
  }
};

/// Every base cell is a leaf below a crowded cell of the top level, any other such cell is one itself; `i` is the
/// number of a top cell.
struct CutCrowded {
  static constexpr uint32_t kMaxMembers = 32;  ///< one tile of pair tests
  Tree tree;

  COLLIDED_HD void operator()(uint64_t i) const {
    const LevelGrid grid = *tree.grid;
    const uint32_t number = static_cast<uint32_t>(i);
    const bool divided = grid.top < grid.base && tree.counts[level_offset(grid.top) + number] > kMaxMembers;
    set(level_offset(grid.top) + number, !divided);
    if (!divided) return;
    for (int level = grid.top + 1; level <= grid.base; ++level) {
      const int depth = 3 * (level - grid.top);
      const uint32_t first = level_offset(level) + (number << depth);
      for (uint32_t k = 0; k < 1u << depth; ++k) set(first + k, level == grid.base);
    }
  }

 private:
  COLLIDED_HD void set(uint32_t cell, bool leaf) const {
    tree.type[cell] = tree.counts[cell] == 0 ? kInactive : leaf ? kLeaf : kInternal;
  }
};

}  // namespace collided
