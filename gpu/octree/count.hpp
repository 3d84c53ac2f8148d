#pragma once
// Section 3.1, "counter octree": how many triangles overlap each cell of every active level.

#include "gpu/exec/atomic.hpp"
#include "gpu/math/lattice.hpp"

namespace collided {

/// units[triangle] = cells of all active levels that its box covers; scanned into offsets for the workload
/// distribution.
struct CountCoveredCells {
  LevelGrid grid;
  Span<const Box<float>> boxes;
  Span<uint64_t> units;

  COLLIDED_HD void operator()(uint64_t triangle) const {
    units[triangle] = triangle < boxes.size() ? grid.covered(boxes[triangle]) : 0;
  }
};

/// One unit for each (triangle, covered cell): adds one to the cell.
/// A triangle adds one to a cell however many of the cell's children it overlaps, so the paper's token test is
/// not needed here: each level's range is walked directly.
struct CountOverlappedCells {
  LevelGrid grid;
  Span<const Box<float>> boxes;
  Span<uint32_t> counts;

  COLLIDED_HD void operator()(uint64_t triangle, uint64_t rank) const {
    atomic_add(counts[grid.covered_cell(boxes[triangle], rank)], 1u);
  }
};

/// Registrations that each level would need if all triangles were registered in it.
struct LevelTotals {
  uint64_t cells[kMaxLevel + 1];
};
struct CoveredPerLevel {
  LevelGrid finest;  ///< with top = 0 and base = kMaxLevel
  Span<const Box<float>> boxes;

  COLLIDED_HD LevelTotals operator()(uint64_t triangle) const {
    LevelTotals totals;
    for (int level = 0; level <= kMaxLevel; ++level) totals.cells[level] = finest.range(level, boxes[triangle]).size();
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
