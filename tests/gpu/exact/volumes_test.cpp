// Tests the sign of a closed mesh's volume against a sum in rationals.

#include "gpu/exact/volumes.hpp"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/gpu/exact/closed_meshes.hpp"

namespace collided::test {
namespace {

int sign(const Mesh& mesh) {
  return sign_of_volume(mesh.triangles, [&](uint32_t v) { return mesh.p[v]; });
}

int sign_in_rationals(const Mesh& mesh) {
  mpq_class volume;
  for (const auto& t : mesh.triangles) {
    mpq_class x[3][3];
    for (size_t i = 0; i < 3; ++i) {
      const Point& p = mesh.p[t[i]];
      x[i][0] = p.x, x[i][1] = p.y, x[i][2] = p.z;
    }
    for (size_t i = 0; i < 3; ++i)
      volume += x[0][i] * (x[1][(i + 1) % 3] * x[2][(i + 2) % 3] - x[1][(i + 2) % 3] * x[2][(i + 1) % 3]);
  }
  return sgn(volume);
}

TEST(Volumes, HaveTheSignOfTheirSide) {
  const Mesh cube = box({0, 0, 0}, {10, 10, 10});
  EXPECT_EQ(sign(cube), 1);
  EXPECT_EQ(sign(reversed(cube)), -1);
  EXPECT_EQ(sign(together(cube, reversed(box({4, 4, 4}, {6, 6, 6})))), 1);
  EXPECT_EQ(sign(together(reversed(cube), box({4, 4, 4}, {6, 6, 6}))), -1);
  EXPECT_EQ(sign(together(cube, reversed(box({20, 0, 0}, {30, 10, 10})))), 0);
  EXPECT_EQ(sign(box({0, 0, 0}, {10, 10, 0})), 0);
  EXPECT_EQ(sign(box({3, 3, 3}, {3, 3, 3})), 0);
  EXPECT_EQ(sign({}), 0);
}

TEST(Volumes, AreExact) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int counts[3] = {};
  for (int i = 0; i < 20000; ++i) {
    Mesh mesh{{}, kTetrahedron};
    for (int k = 0; k < 3; ++k) mesh.p.push_back({uniform(random), uniform(random), uniform(random)});
    const double b = uniform(random), c = uniform(random);
    Point inside = mesh.p[0] + (b * (mesh.p[1] - mesh.p[0]) + c * (mesh.p[2] - mesh.p[0]));
    if (i % 4 == 0) inside.z = std::nextafter(inside.z, uniform(random));
    if (i % 4 == 1) inside = mesh.p[0] + Point{0.5 * (mesh.p[1].x - mesh.p[0].x), 0, 0};
    mesh.p.push_back(inside);
    if (i % 5 == 0)
      mesh = with_points(mesh, [](const Point& p) { return Point{round(2 * p.x), round(p.y), round(p.z)}; });
    if (i % 3 == 0) mesh = with_points(mesh, [](const Point& p) { return p + Point{0x1p40, -0x1p40, 3}; });
    ++counts[sign(mesh) + 1];
    ASSERT_EQ(sign(mesh), sign_in_rationals(mesh)) << i;
  }
  for (const int count : counts) EXPECT_GT(count, 200);
}

/// The second box takes away almost all of the first one's volume, or all, or a little more.
TEST(Volumes, OfAlmostNothing) {
  for (const double offset : {0.0, 0x1p40})
    for (const double unit : {1.0, 0x1p-300, 0x1p-900, 0x1p900}) {
      const auto moved = [&](const Mesh& mesh) {
        return with_points(mesh, [&](const Point& p) { return unit * (p + Point{offset, offset, -offset}); });
      };
      const double little = 0x1p-12;
      for (const double more : {-little, 0.0, little}) {
        const Mesh mesh = together(box({0, 0, 0}, {1, 1, 1}), reversed(box({7, 7, 7}, {8, 8, 8 + more})));
        EXPECT_EQ(sign(moved(mesh)), more < 0 ? 1 : more > 0 ? -1 : 0) << offset << ' ' << unit;
      }
    }
}

TEST(Volumes, ExtremeNumbers) {
  const double tiny = 0x1p-1074, large = 1.7e308;
  for (const Mesh& mesh :
       {box({0, 0, 0}, {tiny, tiny, tiny}), box({-large, -large, -large}, {large, large, large}),
        box({0, 0, 0}, {large, large, tiny}), box({large, large, 0}, {std::nextafter(large, INFINITY), 1.75e308, 1}),
        box({1e300, 1e300, tiny}, {1.1e300, 1.2e300, 2 * tiny}), box({0, 0, 0}, {1e300, 1e-300, 1e-300})}) {
    EXPECT_EQ(sign(mesh), 1);
    EXPECT_EQ(sign(reversed(mesh)), -1);
    EXPECT_EQ(sign(together(mesh, reversed(mesh))), 0);
  }
}

/// 200,000 triangles around a prism whose height is 0, a denormal number or ordinary.
TEST(Volumes, OfManyTriangles) {
  constexpr uint32_t kCorners = 50000;
  for (const double height : {0.0, 0x1p-1074, 1e-9}) {
    Mesh mesh;
    for (uint32_t i = 0; i < kCorners; ++i) {
      const double angle = 2 * M_PI * i / kCorners;
      mesh.p.push_back({std::cos(angle), std::sin(angle), 0});
      mesh.p.push_back({std::cos(angle), std::sin(angle), height});
    }
    for (uint32_t i = 0; i < kCorners; ++i) {
      const uint32_t a = 2 * i, b = (a + 2) % (2 * kCorners);
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
      if (i == 0 || b == 0) continue;
      mesh.triangles.push_back({0, b, a});
      mesh.triangles.push_back({1, a + 1, b + 1});
    }
    EXPECT_EQ(sign(mesh), height > 0);
    EXPECT_EQ(sign(reversed(mesh)), -(height > 0));
  }
}

}  // namespace
}  // namespace collided::test
