// Exact proximity and intersection at rest.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gpu/exact/exact.hpp"
#include "tests/gpu/exact/queries.hpp"

namespace collided::test {
namespace {

void expect_distance(Proximity near, const Point (&p)[4], double distance) {
  EXPECT_TRUE(near(p, distance));
  EXPECT_TRUE(near(p, std::nextafter(distance, 1e300)));
  if (distance > 0) {
    EXPECT_FALSE(near(p, std::nextafter(distance, 0.0)));
    EXPECT_FALSE(near(p, 0));
  }
}

TEST(ExactProximity, VertexTriangleAtExactlyTheThickness) {
  const Point a{0, 0, 0}, b{4, 0, 0}, c{0, 4, 0};
  const Proximity near = proximity<ContactKind::kVertexTriangle>;
  expect_distance(near, {{1, 1, 3}, a, b, c}, 3);
  expect_distance(near, {{2, -3, 4}, a, b, c}, 5);
  expect_distance(near, {{-3, -4, 12}, a, b, c}, 13);
  expect_distance(near, {{1, 1, 0}, a, b, c}, 0);
  expect_distance(near, {{1, -kTiniest, 0}, a, b, c}, kTiniest);
  const Point far[4] = {{0x1p600, 0, 0}, a, b, c};  // at 2^600 - 4, between two doubles
  EXPECT_TRUE(near(far, 0x1p600));
  EXPECT_FALSE(near(far, std::nextafter(0x1p600, 0.0)));
}

TEST(ExactProximity, TriangleWithoutArea) {
  const Point a{0, 0, 0}, b{4, 0, 0};
  const Proximity near = proximity<ContactKind::kVertexTriangle>;
  expect_distance(near, {{2, 3, 4}, a, b, a}, 5);
  expect_distance(near, {{7, 4, 0}, a, {2, 0, 0}, b}, 5);
  expect_distance(near, {{3, 4, 0}, a, a, a}, 5);
}

TEST(ExactProximity, EdgeEdgeAtExactlyTheThickness) {
  const Point a0{0, 0, 0}, a1{4, 0, 0};
  const Proximity near = proximity<ContactKind::kEdgeEdge>;
  expect_distance(near, {a0, a1, {1, -1, 3}, {1, 1, 3}}, 3);
  expect_distance(near, {a0, a1, {1, 3, 4}, {1, 9, 4}}, 5);
  expect_distance(near, {a0, a1, {6, 3, 6}, {9, 3, 6}}, 7);
  expect_distance(near, {a0, a1, {1, 0, 2}, {9, 0, 2}}, 2);  // parallel
  expect_distance(near, {a0, a1, {4, 0, 0}, {9, 0, 0}}, 0);  // collinear, touching
  expect_distance(near, {a0, a1, {6, 0, 0}, {9, 0, 0}}, 2);  // collinear
  expect_distance(near, {a0, a1, {2, 3, 4}, {2, 3, 4}}, 5);  // without length
  expect_distance(near, {a0, a0, {0, 3, 4}, {0, 3, 4}}, 5);
}

struct Triangle {
  Point p[3];
};

/// The answer in every order of the triangles and their corners.
void expect_meet(const Triangle& a, const Triangle& b, bool meet) {
  int order[3] = {0, 1, 2};
  do {
    const Point t[3] = {a.p[order[0]], a.p[order[1]], a.p[order[2]]};
    EXPECT_EQ(exact_triangles_intersect(t, b.p), meet);
    EXPECT_EQ(exact_triangles_intersect(b.p, t), meet);
  } while (std::next_permutation(order, order + 3));
}

const Triangle kFlat{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};

TEST(ExactTriangles, ThatPierceOrTouch) {
  expect_meet(kFlat, {{{1, 1, -1}, {1, 1, 1}, {9, 9, 1}}}, true);
  expect_meet(kFlat, {{{1, 1, 0}, {1, 1, 1}, {9, 9, 1}}}, true);       // a corner in the face
  expect_meet(kFlat, {{{2, 2, 0}, {5, 5, 1}, {5, 5, -1}}}, true);      // a corner on a side
  expect_meet(kFlat, {{{0, 0, 0}, {-1, -1, 1}, {-1, -1, -1}}}, true);  // a common corner
  expect_meet(kFlat, {{{4, 0, 0}, {0, 4, 0}, {4, 4, 7}}}, true);       // a common edge
  expect_meet(kFlat, {{{-1, 1, 0}, {9, 1, 0}, {1, 1, 5}}}, true);      // an edge in the plane
  expect_meet(kFlat, {{{-1, -1, -1}, {-1, -1, 1}, {9, 9, 0}}}, true);  // cuts it in two
  expect_meet(kFlat, kFlat, true);
}

TEST(ExactTriangles, ThatMissByOneUlp) {
  expect_meet(kFlat, {{{1, 1, kTiniest}, {1, 1, 1}, {9, 9, 1}}}, false);
  expect_meet(kFlat, {{{2, std::nextafter(2.0, 3.0), 0}, {5, 5, 1}, {5, 5, -1}}}, false);
  expect_meet(kFlat, {{{-kTiniest, 0, 0}, {-1, -1, 1}, {-1, -1, -1}}}, false);
  expect_meet(kFlat, {{{0, 0, kTiniest}, {4, 0, kTiniest}, {0, 4, kTiniest}}}, false);
  expect_meet(kFlat, {{{-kTiniest, -1, 0}, {-kTiniest, 9, 0}, {-3, 1, 5}}}, false);
}

TEST(ExactTriangles, WhosePlanesCrossElsewhere) {
  expect_meet(kFlat, {{{5, 5, -1}, {5, 5, 1}, {9, 9, 1}}}, false);
  expect_meet(kFlat, {{{3, 3, -1}, {3, 3, 1}, {9, 9, 1}}}, false);
}

TEST(ExactTriangles, InOnePlane) {
  expect_meet(kFlat, {{{1, 1, 0}, {1.5, 1, 0}, {1, 1.5, 0}}}, true);    // inside
  expect_meet(kFlat, {{{-9, -9, 0}, {90, -9, 0}, {-9, 90, 0}}}, true);  // around
  expect_meet(kFlat, {{{-1, 1, 0}, {9, 1, 0}, {9, 2, 0}}}, true);       // outlines cross
  expect_meet(kFlat, {{{2, 2, 0}, {4, 4, 0}, {5, 4, 0}}}, true);        // touches a side
  expect_meet(kFlat, {{{4, 0, 0}, {8, 0, 0}, {8, 1, 0}}}, true);        // touches a corner
  expect_meet(kFlat, {{{3, 3, 0}, {4, 4, 0}, {5, 4, 0}}}, false);
  expect_meet(kFlat, {{{std::nextafter(4.0, 5.0), 0, 0}, {8, 0, 0}, {8, 1, 0}}}, false);
}

TEST(ExactTriangles, WithoutArea) {
  const auto point = [](const Point& p) { return Triangle{{p, p, p}}; };
  expect_meet(kFlat, point({1, 1, 0}), true);
  expect_meet(kFlat, point({1, 1, kTiniest}), false);
  expect_meet(kFlat, point({-kTiniest, 1, 0}), false);
  expect_meet(point({1, 2, 3}), point({1, 2, 3}), true);
  expect_meet(point({1, 2, 3}), point({1, 2, 4}), false);
  expect_meet(kFlat, {{{1, 1, -1}, {1, 1, 1}, {1, 1, 3}}}, true);   // a segment through the face
  expect_meet(kFlat, {{{3, 3, -1}, {3, 3, 1}, {3, 3, 3}}}, false);  // beside it
  expect_meet(kFlat, {{{-1, 1, 0}, {2, 1, 0}, {9, 1, 0}}}, true);   // in the plane, across
  expect_meet({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}}, {{{1, -1, 0}, {1, 0, 0}, {1, 1, 0}}}, true);
  expect_meet({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}}, {{{2, 0, 0}, {3, 0, 0}, {3, 0, 0}}}, true);
  expect_meet({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}}, {{{2.5, 0, 0}, {3, 0, 0}, {3, 0, 0}}}, false);
}

TEST(ExactTriangles, OfAnySize) {
  for (const int exponent : {-1074, -600, 600, 1000}) {
    const auto scaled = [&](Triangle t) {
      for (Point& p : t.p) p = {std::ldexp(p.x, exponent), std::ldexp(p.y, exponent), std::ldexp(p.z, exponent)};
      return t;
    };
    expect_meet(scaled(kFlat), scaled({{{2, 2, 0}, {5, 5, 1}, {5, 5, -1}}}), true);
    expect_meet(scaled(kFlat), scaled({{{3, 2, 0}, {5, 5, 1}, {5, 5, -1}}}), false);
  }
  expect_meet(kFlat, {{{1, 1, 1e300}, {1, 1, -1e300}, {1e300, 1, 0}}}, true);
  expect_meet(kFlat, {{{-kTiniest, 1, 1e300}, {-kTiniest, 1, -1e300}, {-1e300, 1, 0}}}, false);
}

}  // namespace
}  // namespace collided::test
