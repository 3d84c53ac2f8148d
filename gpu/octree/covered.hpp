#pragma once
// The cells that a triangle covers, in a form that threads can hand to each other: how many, and which is the k-th.

#include "gpu/octree/cell_walk.hpp"
#include "gpu/octree/tree.hpp"

namespace collided {

/// The cells of all active dense levels that a triangle covers.
struct CoveredCells {
  static constexpr uint32_t kMostBase = 48;  ///< base cells; triangles with more are left to groups of threads
  /// Triangles whose cells a warp shares: with more of them at once, neighbours would be registered far apart, and the
  /// search for pairs is faster where they are together.
  static constexpr unsigned kShared = 8;
  uint32_t parts = 0;  ///< cells; 0: too many base cells
  uint32_t triangle = 0;

  CoveredCells() = default;
  /// From the level `top` on, down to the base.
  COLLIDED_HD CoveredCells(uint32_t id, const LevelGrid& grid, const CellRange& deepest, int top)
      : triangle(id), levels_(shifted(deepest, kDeepest - grid.base), top, grid.base) {
    if (levels_.cells_at(grid.base) <= kMostBase) parts = levels_.cells();
  }

  /// Index of the k-th cell.
  COLLIDED_HD uint32_t part(uint32_t k) const { return levels_.cell(k); }
  COLLIDED_HD CellWalk walk() const { return {levels_, 0}; }

 private:
  LevelsOfCells levels_;
};

/// The cells of a brick that a triangle covers.
struct CoveredInBrick {
  static constexpr unsigned kShared = 4;  ///< as in CoveredCells; one alone may keep a warp busy
  uint32_t parts = 0;                     ///< cells
  uint32_t triangle = 0, brick = 0;

  CoveredInBrick() = default;
  /// From the level that is `top` levels below the brick's root on, down to the bottom.
  COLLIDED_HD CoveredInBrick(const Tree& tree, const BrickItem& item, const CellRange& deepest, int top)
      : triangle(item.triangle), brick(item.brick) {
    const Brick root = tree.bricks[brick];
    const CellRange range = shifted(deepest, kDeepest - root.level - kBrickLevels);
    levels_ = {{within(range.lo, root.cell), within(range.hi, root.cell)}, top, kBrickLevels};
    parts = levels_.cells();
  }

  COLLIDED_HD uint32_t bottom_cells() const { return levels_.cells_at(kBrickLevels); }
  /// Index of the k-th cell.
  COLLIDED_HD uint32_t part(uint32_t k) const { return brick_cell(brick, levels_.cell(k)); }
  COLLIDED_HD CellWalk walk() const { return {levels_, brick_cell(brick, 0)}; }

 private:
  LevelsOfCells levels_;

  /// A bottom cell, from the first one below the root, kept within the brick.
  COLLIDED_HD static Coords within(const Coords& cell, const Coords& root) {
    return {offset(cell.x, root.x), offset(cell.y, root.y), offset(cell.z, root.z)};
  }
  COLLIDED_HD static uint32_t offset(uint32_t cell, uint32_t root) {
    const uint32_t first = root << kBrickLevels;
    return cell < first ? 0 : smaller(cell - first, (1u << kBrickLevels) - 1u);
  }
};

/// What cells are looked for, where it is the cells themselves.
struct AnyCell {
  COLLIDED_HD static uint32_t look(uint32_t) { return 0; }
  COLLIDED_HD static uint32_t find(uint32_t cell, uint32_t) { return cell; }
};

/// act(wanted.find(cell, wanted.look(cell))), unless it found kNothing, for the dense cells from the level `top` on
/// that a large triangle covers; a group's threads share them.
template <class Wanted, class Act>
COLLIDED_HD void for_each_found(const LevelGrid& grid, int top, const Box<float>& box, const Group& group,
                                const Wanted& wanted, const Act& act) {
  const LevelsOfCells levels(grid.range(grid.base, box), top, grid.base);
  const uint32_t cells = levels.cells();
  if (group.size == 1) {
    CellWalk walk(levels, 0);
    for (uint32_t k = 0; k < cells; ++k)
      if (const uint32_t found = found_in(wanted, walk.next()); found != kNothing) act(found);
    return;
  }
  constexpr uint32_t kAtOnce = 4;  // so that they wait for the memory together
  for (uint32_t first = group.rank; first < cells; first += kAtOnce * group.size) {
    const auto is_cell = [&](uint32_t j) { return first + j * group.size < cells; };
    uint32_t cell[kAtOnce], seen[kAtOnce], found[kAtOnce];
    for (uint32_t j = 0; j < kAtOnce; ++j) cell[j] = is_cell(j) ? levels.cell(first + j * group.size) : 0;
    for (uint32_t j = 0; j < kAtOnce; ++j) seen[j] = is_cell(j) ? wanted.look(cell[j]) : 0;
    for (uint32_t j = 0; j < kAtOnce; ++j) found[j] = is_cell(j) ? wanted.find(cell[j], seen[j]) : kNothing;
    for (uint32_t j = 0; j < kAtOnce; ++j)
      if (found[j] != kNothing) act(found[j]);
  }
}

}  // namespace collided
