// Tests comparisons of distances against a judge that solves for the weights of the closest point in rationals.

#include "gpu/exact/nearest.hpp"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

namespace collided::test {
namespace {

using Point = Vec3<double>;
using Corners = std::array<Point, 3>;
using Vector = std::array<mpq_class, 3>;

mpq_class product(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Returns the square of the distance from 0 to the flat through the corners, if the closest point there is unique and
/// no corner has a weight below 0. The weights solve: all corners have one product with the closest point.
std::optional<mpq_class> square_to_flat(const std::vector<Vector>& corners) {
  const size_t n = corners.size();
  std::vector<std::vector<mpq_class>> m(n + 1, std::vector<mpq_class>(n + 2));  // the last unknown is that product
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = 0; j < n; ++j) m[i][j] = product(corners[i], corners[j]);
    m[i][n] = -1;
    m[n][i] = 1;
  }
  m[n][n + 1] = 1;
  for (size_t k = 0; k <= n; ++k) {
    size_t pivot = k;
    while (pivot <= n && m[pivot][k] == 0) ++pivot;
    if (pivot > n) return std::nullopt;
    std::swap(m[k], m[pivot]);
    for (size_t row = 0; row <= n; ++row) {
      if (row == k) continue;
      const mpq_class factor = m[row][k] / m[k][k];
      for (size_t j = k; j < n + 2; ++j) m[row][j] -= factor * m[k][j];
    }
  }
  for (size_t i = 0; i < n; ++i)
    if (m[i][n + 1] / m[i][i] < 0) return std::nullopt;
  return m[n][n + 1] / m[n][n];
}

mpq_class square_of_distance(const Point& p, const Corners& t) {
  std::optional<mpq_class> least;
  for (unsigned chosen = 1; chosen < 8; ++chosen) {
    std::vector<Vector> corners;
    for (size_t k = 0; k < 3; ++k)
      if (chosen >> k & 1)
        corners.push_back({mpq_class(t[k].x) - mpq_class(p.x), mpq_class(t[k].y) - mpq_class(p.y),
                           mpq_class(t[k].z) - mpq_class(p.z)});
    const auto square = square_to_flat(corners);
    if (square && (!least || *square < *least)) least = square;
  }
  return *least;
}

void expect_truth(const Point& p, const std::vector<Corners>& triangles, int (&counts)[3]) {
  std::vector<mpq_class> squares;
  for (const Corners& t : triangles) squares.push_back(square_of_distance(p, t));
  const auto least = std::min_element(squares.begin(), squares.end()) - squares.begin();
  ASSERT_EQ(nearest_of(p, triangles), static_cast<size_t>(least));
  for (size_t i = 0; i < triangles.size(); ++i)
    for (size_t j = 0; j < triangles.size(); ++j) {
      const int order = cmp(squares[i], squares[j]), sign = (order > 0) - (order < 0);
      ASSERT_EQ(compare_distances(p, triangles[i], triangles[j]), sign);
      if (i != j) ++counts[sign + 1];
    }
}

TEST(Nearest, FullOfTies) {
  std::mt19937 random(1);
  int counts[3] = {};
  for (int i = 0; i < 4000; ++i) {
    std::uniform_int_distribution<int> coordinate(0, 1 + i % 4);
    const auto any_point = [&] {
      const double x = coordinate(random), y = coordinate(random);
      return Point{x, y, static_cast<double>(coordinate(random))};
    };
    const Point p = any_point();
    std::vector<Corners> triangles(4);
    for (Corners& t : triangles)
      for (Point& corner : t) corner = any_point();
    expect_truth(p, triangles, counts);
    if (HasFailure()) return;
  }
  for (const int count : counts) EXPECT_GT(count, 3000);
}

/// Some triangles have a common side, have no area, or differ in one last digit.
TEST(Nearest, OfAnySize) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::uniform_int_distribution<int> exponent(-300, 300);
  int counts[3] = {};
  for (int i = 0; i < 2000; ++i) {
    const double unit = i % 5 == 0 ? 0x1p-300 : std::ldexp(1.0, exponent(random));
    const Point offset = i % 3 == 0 ? Point{0x1p40, 0x1p40, -0x1p40} : Point{0, 0, 0};
    const auto any_point = [&] {
      const double own = i % 8 == 1 ? std::ldexp(1.0, exponent(random) / 2) : 1;
      const double x = uniform(random), y = uniform(random);
      return unit * own * (Point{x, y, uniform(random)} + offset);
    };
    Corners t = {any_point(), any_point(), any_point()};
    const Corners neighbour = {t[1], t[0], any_point()}, segment = {t[0], t[1], t[1]}, point = {t[0], t[0], t[0]};
    Corners moved = t;
    moved[i % 3].x = std::nextafter(moved[i % 3].x, 0);
    expect_truth(any_point(), {t, neighbour, segment, point, moved}, counts);
    if (HasFailure()) return;
  }
  for (const int count : counts) EXPECT_GT(count, 1000);
}

TEST(Nearest, ExtremeNumbers) {
  const double tiny = 0x1p-1074, large = 1e300;
  const Corners flat = {{{0, 0, 0}, {large, 0, 0}, {0, large, 0}}},
                above = {{{0, 0, tiny}, {large, 0, tiny}, {0, 1, tiny}}},
                corner = {{{tiny, tiny, 0}, {tiny, tiny, 0}, {tiny, tiny, 0}}};
  int counts[3] = {};
  for (const Point& p : {Point{0, 0, 0}, Point{tiny, tiny, tiny}, Point{large, large, tiny}, Point{-tiny, 0, -large},
                         Point{large, tiny, 0}, Point{-1.7e308, 1.7e308, 1}})
    expect_truth(p, {flat, above, corner}, counts);
}

TEST(Nearest, IsTheFirstOfEquals) {
  const Corners far = {{{9, 0, 0}, {9, 1, 0}, {9, 0, 1}}}, right = {{{1, 0, 0}, {1, 1, 0}, {1, 0, 1}}},
                left = {{{-1, 0, 0}, {-1, 1, 0}, {-1, 0, 1}}};
  EXPECT_EQ(nearest_of({0, 0, 0}, std::vector<Corners>{far, right, left}), 1u);
  EXPECT_EQ(nearest_of({0, 0, 0}, std::vector<Corners>{left, far, right}), 0u);
  EXPECT_EQ(compare_distances({0, 0, 0}, left, right), 0);
  EXPECT_EQ(compare_distances({0, 0, 0}, left, far), -1);
  EXPECT_EQ(compare_distances({0, 0, 0}, far, left), 1);
}

}  // namespace
}  // namespace collided::test
