#pragma once
// Sheets of cloth and what becomes of them over a few frames.

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "tests/support/case.hpp"

namespace collided::test {

/// The triangles of a grid of n x n vertices, vertex (i, j) being i n + j.
inline std::vector<std::array<uint32_t, 3>> grid_triangles(uint32_t n) {
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 0; i + 1 < n; ++i)
    for (uint32_t j = 0; j + 1 < n; ++j) {
      const uint32_t v = i * n + j;
      triangles.push_back({v, v + 1, v + n});
      triangles.push_back({v + n, v + 1, v + n + 1});
    }
  return triangles;
}

inline Positions grid(uint32_t n, const std::function<Vec3d(double, double)>& place) {
  Positions positions;
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = 0; j < n; ++j) positions.push_back(place(i, j));
  return positions;
}

inline Positions flat_grid(uint32_t n, double spacing) {
  return grid(n, [&](double i, double j) { return Vec3d{i * spacing, j * spacing, 0}; });
}

inline Positions shaken(Positions positions, uint32_t seed, double by) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-by, by);
  for (Vec3d& p : positions)
    for (double& x : p) x += shake(random);
  return positions;
}

/// Three sheets of spacing 1, folded in the middle, their halves 0.7 apart, on their way through three frames, over one
/// that stands still; `change` is made to each frame's case.
inline std::vector<Case> folded_sheets(const std::function<Case(Case)>& change) {
  constexpr uint32_t kSide = 6;
  const auto folded = [](const Vec3d& at) {
    return grid(kSide, [&](double i, double j) {
      const bool is_below = i < kSide / 2;
      return Vec3d{at[0] + (is_below ? i : kSide - 1 - i), at[1] + j, at[2] + (is_below ? 0 : 0.7)};
    });
  };
  const Vec3d places[] = {{0, 0, 0}, {1.3, 0.4, 0.3}, {2.2, -0.3, 1.2}, {0.4, 0.6, -0.4}};
  std::vector<Case> frames(3);
  for (uint32_t m = 0; m < std::size(places); ++m) {
    Positions before = shaken(folded(places[m]), 10 + m, 0.1);
    for (uint32_t f = 0; f < frames.size(); ++f) {
      const bool is_static = m == 3;
      const Positions after = is_static ? before : shaken(before, 20 + 4 * m + f, 0.35);
      add_mesh(frames[f], grid_triangles(kSide), before, after, is_static);
      before = after;
    }
  }
  for (Case& c : frames) c = change(std::move(c));
  return frames;
}

}  // namespace collided::test
