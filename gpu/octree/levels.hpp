#pragma once
// Section 3.2: which levels the next frame uses.
// Deviation: the first frame's base level comes from the data, not from a fixed nine levels, and no frame's base
// level may need more than a bounded number of registrations for a triangle (one huge triangle would cover all).

#include "gpu/octree/count.hpp"

namespace collided {

struct ActiveLevels {
  int top = 0;
  int base = -1;  ///< -1: no frame yet
};

/// Levels for this frame; `triangles` > 0.
inline ActiveLevels clamp_levels(ActiveLevels wanted, const LevelTotals& totals, uint64_t triangles) {
  constexpr uint64_t kFirstPerTriangle = 6, kMostPerTriangle = 24;
  const bool first_frame = wanted.base < 0;
  const uint64_t most = triangles * (first_frame ? kFirstPerTriangle : kMostPerTriangle);
  int base = first_frame ? kMaxLevel : wanted.base;
  while (base > 0 && totals.cells[base] > most) --base;
  return {wanted.top < base ? wanted.top : base, base};
}

/// `share[l]`: registrations in leaves of level l; thresholds of the paper.
inline ActiveLevels next_levels(ActiveLevels now, const uint64_t (&registrations)[kMaxLevel + 1]) {
  constexpr double kEpsilonMinus = 0.001, kEpsilonPlus = 0.00001, kLambdaPlus = 0.97, kLambdaMinus = 0.03;
  double all = 0;
  for (const uint64_t n : registrations) all += static_cast<double>(n);
  if (all == 0) return now;
  const double at_top = static_cast<double>(registrations[now.top]) / all;
  const double at_base = static_cast<double>(registrations[now.base]) / all;
  ActiveLevels next = now;
  if (at_top > kEpsilonMinus && next.top > 0) --next.top;
  if (at_top < kEpsilonPlus && next.top < next.base) ++next.top;
  if (at_base > kLambdaPlus && next.base < kMaxLevel) ++next.base;
  if (at_base < kLambdaMinus && next.base > next.top) --next.base;
  return next;
}

}  // namespace collided
