#pragma once
// Section 3.1, "counter octree": how many triangles overlap each cell of every active level.
// A triangle adds one to a cell however many of the cell's children it overlaps, so the paper's token test is not
// needed here: each level's range is walked directly.

#include "gpu/engines/octree/covered.hpp"

namespace collided {

/// Cells that a group works on at once, where all active dense cells have their turn.
constexpr uint32_t kCellsOfGroup = 256;

/// How many groups that takes.
COLLIDED_HD inline uint64_t groups_of_cells(const LevelGrid& grid) {
  const uint32_t cells = level_offset(grid.base + 1) - level_offset(grid.top);
  return (cells + kCellsOfGroup - 1) / kCellsOfGroup;
}
/// The i-th group's cells.
struct CellSlice {
  uint32_t first, count;

  COLLIDED_HD CellSlice(const LevelGrid& grid, uint64_t i)
      : first(level_offset(grid.top) + static_cast<uint32_t>(i) * kCellsOfGroup),
        count(min(kCellsOfGroup, level_offset(grid.base + 1) - first)) {}
};

/// The cells of each triangle; none of a triangle that covers many, or that is left out.
struct CellsOfTriangles {
  using Item = CoveredCells;
  const LevelGrid* grid;
  Span<const Box<float>> boxes;

  COLLIDED_HD Item operator()(uint64_t i) const { return from_level(grid->top, i); }
  /// Those from a level on.
  COLLIDED_HD Item from_level(int top, uint64_t i) const {
    const LevelGrid g = *grid;
    const Box<float> box = boxes[i];
    if (is_no_box(box)) return {};
    return {static_cast<uint32_t>(i), g, g.deepest_range(box), top};
  }
  COLLIDED_HD bool are_many(uint64_t i, const Item& item) const { return item.parts == 0 && !is_no_box(boxes[i]); }
};

struct CountOverlappedCells {
  using Item = CoveredCells;
  static constexpr bool kWalks = true;
  CellsOfTriangles cells;
  Span<uint32_t> counts;
  AppendList<uint32_t> large;  ///< triangles that cover many base cells

  COLLIDED_HD Item item(uint64_t i) const {
    const Item item = cells(i);
    if (cells.are_many(i, item)) large.push(item.triangle);
    return item;
  }
  COLLIDED_HD static uint32_t look(uint32_t cell) { return AnyCell::look(cell); }
  COLLIDED_HD static uint32_t find(uint32_t cell, uint32_t seen) { return AnyCell::find(cell, seen); }
  COLLIDED_HD void act(const Item&, uint32_t cell) const { count_in(counts, cell); }
};

/// The cells of each of some triangles that cover many.
struct CellsOfLarge {
  using Item = ManyCoveredCells;
  const LevelGrid* grid;
  Span<const Box<float>> boxes;
  Span<const uint32_t> large;

  COLLIDED_HD Item operator()(uint64_t i) const { return from_level(grid->top, i); }
  /// Those from a level on.
  COLLIDED_HD Item from_level(int top, uint64_t i) const {
    const LevelGrid g = *grid;
    return {large[i], g, g.deepest_range(boxes[large[i]]), top};
  }
};

struct CountCellsOfLarge {
  using Item = ManyCoveredCells;
  CellsOfLarge cells;
  Span<uint32_t> counts;

  COLLIDED_HD Item item(uint64_t i) const { return cells(i); }
  COLLIDED_HD static uint32_t look(uint32_t cell) { return AnyCell::look(cell); }
  COLLIDED_HD static uint32_t find(uint32_t cell, uint32_t seen) { return AnyCell::find(cell, seen); }
  COLLIDED_HD void act(const Item&, uint32_t cell) const { count_in(counts, cell); }
};

/// Registrations that each dense level would need if all triangles were registered in it.
struct LevelTotals {
  uint64_t cells[kMaxLevel + 1];

  /// How many triangles have boxes: each covers the one cell of level 0.
  COLLIDED_HD uint64_t boxed() const { return cells[0]; }
};
struct CoveredPerLevel {
  const Box<float>* bounds;
  Span<const Box<float>> boxes;

  COLLIDED_HD LevelTotals operator()(uint64_t triangle) const {
    const Box<float> box = boxes[triangle];
    LevelTotals totals{};
    if (is_no_box(box)) return totals;
    const CellRange deepest = grid_over(*bounds, 0, kMaxLevel).deepest_range(box);
    for (int level = 0; level <= kMaxLevel; ++level) totals.cells[level] = shifted(deepest, kDeepest - level).size();
    return totals;
  }
};
struct AddTotals {
  COLLIDED_HD LevelTotals operator()(const LevelTotals& a, const LevelTotals& b) const {
    LevelTotals sum;
    for (int level = 0; level <= kMaxLevel; ++level) sum.cells[level] = a.cells[level] + b.cells[level];
    return sum;
  }
};

}  // namespace collided
