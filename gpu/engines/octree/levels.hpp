#pragma once
// Section 3.2: which levels the next frame uses.
// Deviation: the first frame's base level comes from the data, not from a fixed nine levels, and no frame's base
// level may need more than a bounded number of registrations for a triangle that has a box (one huge triangle would
// cover all).

#include "gpu/engines/octree/top_down.hpp"

namespace collided {

struct ActiveLevels {
  int top = 0;
  int base = -1;            ///< -1: no frame yet
  int deepest = kMaxLevel;  ///< that the base may be

  bool operator==(const ActiveLevels&) const = default;
};

/// The deepest base level of a scene: dense levels cost memory, and the time to clear it, for each of their cells,
/// so that they may have no more than a bounded number of cells for each triangle. Triangles that cover a surface are
/// as large as a cell two levels or more above.
inline int deepest_base(uint64_t triangles) {
  constexpr uint64_t kCellsPerTriangle = 128;
  int level = kBrickLevels;
  while (level < kMaxLevel && uint64_t{1} << (3 * (level + 1)) <= kCellsPerTriangle * triangles) ++level;
  return level;
}

/// Levels for this frame.
COLLIDED_HD inline ActiveLevels clamp_levels(ActiveLevels wanted, const LevelTotals& totals) {
  constexpr uint64_t kFirstPerTriangle = 6, kMaxPerTriangle = 24;
  const bool first_frame = wanted.base < 0;
  const uint64_t most = totals.boxed() * (first_frame ? kFirstPerTriangle : kMaxPerTriangle);
  int base = first_frame ? wanted.deepest : wanted.base;
  while (base > 0 && totals.cells[base] > most) --base;
  // Coarse levels are wanted only where many registrations were in them; counting them is slow, for few cells take
  // the counts of many triangles.
  constexpr int kFirstLevels = 4;
  const int top = !first_frame ? wanted.top : base > kFirstLevels ? base - kFirstLevels : 0;
  return {top < base ? top : base, base};
}

/// `registrations[l]`: in leaves of dense level l; thresholds of the paper.
inline ActiveLevels next_levels(ActiveLevels now, const uint64_t* registrations) {
  constexpr double kEpsilonMinus = 0.001, kEpsilonPlus = 0.00001, kLambdaPlus = 0.97, kLambdaMinus = 0.03;
  double all = 0;
  for (int level = 0; level <= kMaxLevel; ++level) all += static_cast<double>(registrations[level]);
  if (all == 0) return now;
  const double at_top = static_cast<double>(registrations[now.top]) / all;
  const double at_base = static_cast<double>(registrations[now.base]) / all;
  ActiveLevels next = now;
  if (at_top > kEpsilonMinus && next.top > 0) --next.top;
  if (at_top < kEpsilonPlus && next.top < next.base) ++next.top;
  if (at_base > kLambdaPlus && next.base < now.deepest) ++next.base;
  if (at_base < kLambdaMinus && next.base > next.top) --next.base;
  return next;
}

/// Sets up the frame's grid, and how many items the launches that depend on it have.
struct GridState {
  LevelGrid grid;
  uint64_t top_cells, base_cells;
  uint64_t roots[3];  ///< of the steps of CutDense
  uint64_t cell_groups;
};
COLLIDED_HD inline GridState grid_state(const LevelGrid& grid) {
  GridState state{grid, uint64_t{1} << (3 * grid.top), uint64_t{1} << (3 * grid.base), {}, groups_of_cells(grid)};
  for (int step = 0; step < 3; ++step) state.roots[step] = roots_of_step(grid, step);
  return state;
}
struct ChooseGrid {
  const Box<float>* bounds;
  const LevelTotals* totals;
  const ActiveLevels* wanted;
  GridState* state;

  COLLIDED_HD void operator()(uint64_t) const {
    const ActiveLevels levels = clamp_levels(*wanted, *totals);
    *state = grid_state(grid_over(*bounds, levels.top, levels.base));
  }
};
}  // namespace collided
