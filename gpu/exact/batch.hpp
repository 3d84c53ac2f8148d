#pragma once
// Exact decisions for many pairs of features, on a pool of host threads.

#include <array>
#include <functional>
#include <vector>

#include "gpu/exact/exact.hpp"

namespace collided {

struct ExactQuestion {
  bool vertex_triangle = true;           ///< else edge-edge
  bool continuous = true;                ///< else the positions at t = 1 alone count
  double thickness = 0;                  ///< >= 0
  int threads = 0;                       ///< 0: all cores
  std::function<bool()> cancelled = {};  ///< asked now and then; throws Cancelled if it says so
};

/// v a b c or a0 a1 b0 b1: at t = 0, then at t = 1.
using ExactPoints = std::array<Vec3<double>, 8>;

struct ExactAnswer {
  bool hit = false;
  double toi = 0;        ///< as ExactImpact::toi; 0 if not continuous
  bool initial = false;  ///< in contact at t = 0
};

/// One answer for each pair.
std::vector<ExactAnswer> decide_exactly(const ExactQuestion& question, const std::vector<ExactPoints>& pairs);

/// Whether the closed triangles of each pair (three points each) have a point in common.
std::vector<ExactAnswer> decide_triangles_exactly(const ExactQuestion& question,
                                                  const std::vector<std::array<Vec3<double>, 6>>& pairs);

}  // namespace collided
