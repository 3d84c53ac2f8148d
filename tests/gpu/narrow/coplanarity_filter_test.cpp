// The filter rules out no triple of vectors that is coplanar at some time, in exact arithmetic.
#include "gpu/narrow/coplanarity_filter.hpp"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

namespace collided::test {
namespace {

using Vectors = std::array<Vec3<float>, 3>;

mpq_class exact_determinant(const Vectors& v) {
  const auto minor = [&](float a, float d, float b, float c) { return mpq_class(a) * d - mpq_class(b) * c; };
  return v[0].x * minor(v[1].y, v[2].z, v[1].z, v[2].y) - v[0].y * minor(v[1].x, v[2].z, v[1].z, v[2].x) +
         v[0].z * minor(v[1].x, v[2].y, v[1].y, v[2].x);
}

bool is_ruled_out(const Vectors& start, const Vectors& end, float thickness = 0) {
  const Vec3<float> x[3] = {start[0], start[1], start[2]}, y[3] = {end[0], end[1], end[2]};
  return NeverCoplanar{thickness}(x, y);
}

/// Nearly coplanar: the third is the sum of the others, rounded. One of them, `longest`, is much longer.
Vectors nearly_coplanar(std::mt19937& random, int longest) {
  std::uniform_real_distribution<float> component(-1, 1);
  const auto vector = [&](float scale) {
    return Vec3<float>{scale * component(random), scale * component(random), scale * component(random)};
  };
  Vectors v{vector(longest == 0 ? 100.0f : 0.01f), vector(longest == 1 ? 100.0f : 0.01f), {}};
  v[2] = longest == 2 ? vector(0.01f) : v[0] + v[1];
  if (longest == 2) v[2] = 50.0f * (v[0] + v[1]);
  return v;
}

// One determinant in float is off by as much as the longest vectors allow, whichever they are.
TEST(CoplanarityFilter, TheSignsThatItTellsAreRight) {
  std::mt19937 random(1);
  int ruled_out = 0, decided_ends = 0;
  for (int i = 0; i < 60'000; ++i) {
    const int longest = i % 3;
    Vectors v = nearly_coplanar(random, longest);
    if (i % 2) std::swap(v[0], v[1]);
    if (!is_ruled_out(v, v)) continue;
    ++ruled_out;
    decided_ends += sgn(exact_determinant(v)) != 0;
  }
  EXPECT_EQ(decided_ends, ruled_out);
}

TEST(CoplanarityFilter, WhatIsFarFromCoplanarIsRuledOutUnlessItTurnsOver) {
  const Vectors base{Vec3<float>{1, 0, 0}, Vec3<float>{0, 1, 0}, Vec3<float>{0, 0, 1}};
  Vectors over = base;
  over[2].z = -1;
  EXPECT_TRUE(is_ruled_out(base, base));
  EXPECT_TRUE(is_ruled_out(over, over));
  EXPECT_FALSE(is_ruled_out(base, over));
  EXPECT_FALSE(is_ruled_out(base, base, 1.0f));  // within the thickness
  EXPECT_TRUE(is_ruled_out(base, base, 0.9f));
  for (int k = 0; k < 3; ++k) {  // too large to be decided
    Vectors large = base;
    large[static_cast<size_t>(k)] = 300.0f * large[static_cast<size_t>(k)];
    EXPECT_FALSE(is_ruled_out(large, large)) << k;
    EXPECT_FALSE(is_ruled_out(base, large)) << k;
  }
}

}  // namespace
}  // namespace collided::test
