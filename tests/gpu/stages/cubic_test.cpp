// Roots of the coplanarity cubic against polynomials with known roots.

#include "gpu/narrow/cubic.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace collided::test {
namespace {

Cubic<double> from_roots(double scale, double a, double b, double c) {
  Cubic<double> f{};
  f.c3 = scale;
  f.c2 = -scale * (a + b + c);
  f.c1 = scale * (a * b + b * c + c * a);
  f.c0 = -scale * a * b * c;
  return f;
}

TEST(Cubic, FindsTheRootsInTheUnitIntervalInOrder) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 2.0);
  for (int i = 0; i < 5000; ++i) {
    double r[3] = {any(random), any(random), any(random)};
    std::sort(r, r + 3);
    const double gap = std::min(r[1] - r[0], r[2] - r[1]);
    const auto near_end = [](double x) { return std::abs(x) < 1e-6 || std::abs(x - 1) < 1e-6; };
    if (gap < 1e-3 || near_end(r[0]) || near_end(r[1]) || near_end(r[2])) continue;
    std::vector<double> expected;
    for (const double x : r)
      if (x > 0 && x < 1) expected.push_back(x);
    double found[3];
    const int n = roots_in_unit(from_roots(i % 2 == 0 ? 3.0 : -0.01, r[0], r[1], r[2]), found);
    ASSERT_EQ(static_cast<size_t>(n), expected.size());
    for (int k = 0; k < n; ++k) EXPECT_NEAR(found[k], expected[static_cast<size_t>(k)], 1e-9);
  }
}

TEST(Cubic, PowerAndBernsteinFormsAreTheDeterminant) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  Vec3<double> x[3], y[3];
  for (int i = 0; i < 3; ++i) {
    x[i] = {any(random), any(random), any(random)};
    y[i] = {any(random), any(random), any(random)};
  }
  const Cubic<double> f = moving_triple(x, y);
  for (const double t : {0.0, 0.25, 0.5, 1.0}) {
    const auto at = [&](int i) { return x[i] + t * (y[i] - x[i]); };
    EXPECT_NEAR(f(t), triple(at(0), at(1), at(2)), 1e-12);
  }
}

TEST(Cubic, LinearQuadraticAndConstantAreCubicsToo) {
  double found[3];
  EXPECT_EQ(roots_in_unit(Cubic<double>{-0.5, 1, 0, 0, 0, 0, 0, 0}, found), 1);
  EXPECT_NEAR(found[0], 0.5, 1e-12);
  EXPECT_EQ(roots_in_unit(Cubic<double>{0.1875, -1, 1, 0, 0, 0, 0, 0}, found), 2);
  EXPECT_NEAR(found[0], 0.25, 1e-12);
  EXPECT_NEAR(found[1], 0.75, 1e-12);
  EXPECT_EQ(roots_in_unit(Cubic<double>{2, 0, 0, 0, 0, 0, 0, 0}, found), 0);
}

}  // namespace
}  // namespace collided::test
