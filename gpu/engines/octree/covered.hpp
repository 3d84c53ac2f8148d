#pragma once
// The cells that a triangle covers, in a form that threads can hand to each other: how many, and which is the k-th.

#include "gpu/engines/octree/cell_walk.hpp"
#include "gpu/engines/octree/tree.hpp"

namespace collided {

/// The cells of all active dense levels that a triangle covers.
struct CoveredCells {
  static constexpr uint32_t kMaxBase = 48;  ///< base cells; triangles with more are left to groups of threads
  /// Triangles whose cells a warp shares: with more of them at once, neighbours would be registered far apart, and the
  /// search for pairs is faster where they are together.
  static constexpr unsigned kShared = 8;
  uint32_t parts = 0;  ///< cells; 0: too many base cells
  uint32_t triangle = 0;

  CoveredCells() = default;
  /// From the level `top` on, down to the base.
  COLLIDED_HD CoveredCells(uint32_t id, const LevelGrid& grid, const CellRange& deepest, int top)
      : triangle(id), levels_(shifted(deepest, kDeepest - grid.base), top, grid.base) {
    if (levels_.cells_at(grid.base) <= kMaxBase) parts = levels_.cells();
  }

  /// Index of the k-th cell.
  COLLIDED_HD uint32_t part(uint32_t k) const { return levels_.cell(k); }
  COLLIDED_HD CellWalk walk() const { return {levels_, 0}; }

 private:
  LevelsOfCells levels_;
};

/// The same cells of a triangle that covers many.
struct ManyCoveredCells {
  uint32_t parts = 0;  ///< cells
  uint32_t triangle = 0;

  ManyCoveredCells() = default;
  COLLIDED_HD ManyCoveredCells(uint32_t id, const LevelGrid& grid, const CellRange& deepest, int top)
      : triangle(id), levels_(shifted(deepest, kDeepest - grid.base), top, grid.base) {
    parts = levels_.cells();
  }

  COLLIDED_HD uint32_t part(uint32_t k) const { return levels_.cell(k); }
  COLLIDED_HD CellWalk walk_from(uint32_t k) const { return {levels_, 0, k}; }

 private:
  LevelsOfCells levels_;
};

/// The cells of a brick that a triangle covers.
struct CoveredInBrick {
  static constexpr unsigned kShared = 4;  ///< as in CoveredCells; one alone may keep a warp busy
  uint32_t parts = 0;                     ///< cells
  uint32_t triangle = 0;
  uint32_t first = 0;  ///< index of the brick's first cell

  CoveredInBrick() = default;
  /// From the level that is `top` levels below the brick's root on, down to the bottom.
  COLLIDED_HD CoveredInBrick(const Tree& tree, const BrickItem& item, const CellRange& deepest, int top)
      : triangle(item.triangle), first(tree.brick_cell(item.brick, 1)) {
    const Brick root = tree.bricks[item.brick];
    const CellRange range = shifted(deepest, kDeepest - root.level - kBrickLevels);
    levels_ = {{within(range.lo, root.cell), within(range.hi, root.cell)}, top, kBrickLevels};
    parts = levels_.cells();
  }

  COLLIDED_HD uint32_t bottom_cells() const { return levels_.cells_at(kBrickLevels); }
  /// Index of the k-th cell.
  COLLIDED_HD uint32_t part(uint32_t k) const { return first - 1 + levels_.cell(k); }
  COLLIDED_HD CellWalk walk() const { return {levels_, first - 1}; }

 private:
  LevelsOfCells levels_;

  /// A bottom cell, from the first one below the root, kept within the brick.
  COLLIDED_HD static Coords within(const Coords& cell, const Coords& root) {
    return {offset(cell.x, root.x), offset(cell.y, root.y), offset(cell.z, root.z)};
  }
  COLLIDED_HD static uint32_t offset(uint32_t cell, uint32_t root) {
    const uint32_t first = root << kBrickLevels;
    return cell < first ? 0 : min(cell - first, (1u << kBrickLevels) - 1u);
  }
};

/// What cells are looked for, where it is the cells themselves.
struct AnyCell {
  COLLIDED_HD static uint32_t look(uint32_t) { return 0; }
  COLLIDED_HD static uint32_t find(uint32_t cell, uint32_t) { return cell; }
};

}  // namespace collided
