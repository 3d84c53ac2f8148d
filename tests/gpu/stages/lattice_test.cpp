// Cells, their numbers (paper Fig. 6) and the monotone map from positions.

#include "gpu/base/lattice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace collided::test {
namespace {

TEST(Lattice, LevelOffsetsAreSumsOfPowersOfEight) {
  EXPECT_EQ(level_offset(0), 0u);
  EXPECT_EQ(level_offset(1), 1u);
  EXPECT_EQ(level_offset(2), 9u);
  EXPECT_EQ(level_offset(8), 2396745u);
}

TEST(Lattice, ChildrenFollowTheirParentAsInFigureSix) {
  for (int level = 0; level < 5; ++level) {
    const uint32_t side = 1u << level;
    for (uint32_t x = 0; x < side; x += 1 + side / 5)
      for (uint32_t y = 0; y < side; y += 1 + side / 5) {
        const Coords cell{x, y, side - 1};
        const uint32_t id = cell_id(level, cell);
        EXPECT_EQ(level_of(id), level);
        for (uint32_t k = 0; k < 8; ++k) {
          const Coords child{2 * cell.x + (k & 1), 2 * cell.y + (k >> 1 & 1), 2 * cell.z + (k >> 2)};
          EXPECT_EQ(cell_id(level + 1, child), 8 * id + 1 + k);
        }
      }
  }
}

TEST(Lattice, MortonCodesGoBackToTheirCoordinates) {
  for (uint32_t code = 0; code < (1u << 21); code += 37) EXPECT_EQ(morton(morton_coords(code)), code);
}

TEST(Lattice, MapIsMonotoneAndClampedForEveryNumber) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity(), kScale = 174762.67f;
  const auto quantise = [](float x) { return LevelGrid::quantise(x, -1.0f, kScale); };
  EXPECT_EQ(quantise(-kInfinity), 0u);
  EXPECT_EQ(quantise(kInfinity), (1u << kDeepest) - 1);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> any(-3.0f, 5.0f);
  for (int i = 0; i < 10000; ++i) {
    const float a = any(random), b = any(random);
    EXPECT_LE(quantise(std::min(a, b)), quantise(std::max(a, b)));
  }
}

TEST(Lattice, GridOverNothingHasOneCell) {
  const LevelGrid point = grid_over({{3, 3, 3}, {3, 3, 3}}, 0, 5);
  EXPECT_EQ(point.deepest_range({{3, 3, 3}, {3, 3, 3}}).size(), 1u);
  EXPECT_EQ(point.deepest_range({{-1e30f, 3, 3}, {1e30f, 3, 3}}).size(), 1u);
}

TEST(Rounding, NextNumbersAreTheStandardLibrarys) {
  for (const float x : {0.0f, -0.0f, 1.0f, -1.0f, 1e-45f, -1e-45f, 3.4e38f, -3.4e38f, 0.1f}) {
    EXPECT_EQ(next_up(x), std::nextafter(x, std::numeric_limits<float>::infinity())) << x;
    EXPECT_EQ(next_down(x), std::nextafter(x, -std::numeric_limits<float>::infinity())) << x;
  }
  for (const double x : {0.1, -0.1, 1e300, -1e300, 1e-320, 1.0, 16777217.0}) {
    EXPECT_LE(static_cast<double>(float_below(x)), x);
    EXPECT_GE(static_cast<double>(float_above(x)), x);
  }
}

}  // namespace
}  // namespace collided::test
