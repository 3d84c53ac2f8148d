// Exact impacts of moving features against times known by construction; all coordinates are exact doubles.

#include "gpu/exact/exact.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/gpu/exact/queries.hpp"

namespace collided::test {
namespace {

void expect_impact(const ExactImpact& found, double toi) {
  EXPECT_TRUE(found.hit);
  EXPECT_EQ(found.toi, toi);
}

void expect_miss(const ExactImpact& found) {
  EXPECT_FALSE(found.hit);
  EXPECT_EQ(found.toi, 1);
}

/// a along x through the origin, b along y at height `from`, then `to`.
Query crossing_edges(double from, double to, double thickness = 0) {
  return {{{-1, 0, 0}, {1, 0, 0}, {0, -1, from}, {0, 1, from}},
          {{-1, 0, 0}, {1, 0, 0}, {0, -1, to}, {0, 1, to}},
          thickness};
}

TEST(ExactVertexTriangle, DyadicTimes) {
  expect_impact(vertex_triangle(vertex_at_corner_triangle({1, 1, 1}, {1, 1, -1})), 0.5);
  expect_impact(vertex_triangle(vertex_at_corner_triangle({1, 1, 3}, {1, 1, -1})), 0.75);
  expect_impact(vertex_triangle(vertex_at_corner_triangle({1, 1, 0}, {1, 1, 5})), 0);
  expect_impact(vertex_triangle(vertex_at_corner_triangle({1, 1, 5}, {1, 1, 0})), 1);
}

TEST(ExactVertexTriangle, OntoSidesAndCorners) {
  for (const Point& at : {Point{2, 0, 0}, Point{0, 2, 0}, Point{2, 2, 0}, kOrigin, Point{4, 0, 0}, Point{0, 4, 0}})
    expect_impact(vertex_triangle(vertex_at_corner_triangle(at + Point{0, 0, 1}, at - Point{0, 0, 1})), 0.5);
}

TEST(ExactVertexTriangle, MissesByOneUlp) {
  expect_miss(vertex_triangle(vertex_at_corner_triangle({1, 1, 5}, {1, 1, kTiniest})));
  expect_miss(vertex_triangle(vertex_at_corner_triangle({1, -kTiniest, 1}, {1, -kTiniest, -1})));
  const double beyond = std::nextafter(2.0, 3.0);
  expect_miss(vertex_triangle(vertex_at_corner_triangle({2, beyond, 1}, {2, beyond, -1})));
  const ExactImpact just = vertex_triangle(vertex_at_corner_triangle({1, 1, 1}, {1, 1, -kTiniest}));
  expect_impact(just, std::nextafter(1.0, 0.0));  // 1 / (1 + 2^-1074), rounded toward 0
}

TEST(ExactVertexTriangle, RationalTimeRoundedDown) {
  const double toi = vertex_triangle(vertex_at_corner_triangle({1, 1, 1}, {1, 1, -2})).toi;
  expect_last_double(toi, [](double t) { return std::fma(3, t, -1) <= 0; });
  const double tiny = vertex_triangle(vertex_at_corner_triangle({1, 1, kTiniest}, {1, 1, -1})).toi;
  EXPECT_EQ(tiny, 0);  // below 2^-60
}

TEST(ExactVertexTriangle, CubicTime) {
  // Height of the vertex over the plane, times a positive factor: -(t^3 + t^2 - t - 1/2).
  const Query q = {{{0, 1, 1}, kOrigin, {4, 0, 0}, {0, 4, 2}}, {{1, 1, 1}, kOrigin, {4, 0, 4}, {0, 8, 2}}};
  const ExactImpact found = vertex_triangle(q);
  ASSERT_TRUE(found.hit);
  const auto cubic = [](long double t) { return ((t + 1) * t - 1) * t - 0.5L; };
  expect_last_double(found.toi, [&](double t) { return cubic(t) <= 0; });
}

TEST(ExactVertexTriangle, InThePlaneForAMomentOnASide) {
  // The plane comes down to the vertex at t = 1/2, when the vertex is on the side x = 0.
  const Query q = {{{-2, 1, 0.75}, kOrigin, {4, 0, 0}, {0, 4, 4}}, {{2, 1, 0.75}, kOrigin, {4, 0, 0}, {0, 4, 2}}};
  expect_impact(vertex_triangle(q), 0.5);
}

TEST(ExactVertexTriangle, IdenticallyCoplanar) {
  expect_impact(vertex_triangle(vertex_at_corner_triangle({-4, 1, 0}, {4, 1, 0})), 0.5);
  expect_impact(vertex_triangle(vertex_at_corner_triangle({-4, 4, 0}, {4, 4, 0})), 0.5);
  expect_miss(vertex_triangle(vertex_at_corner_triangle({-4, 5, 0}, {4, 5, 0})));
  expect_impact(vertex_triangle(vertex_at_corner_triangle({0, -4, 0}, {0, 4, 0})), 0.5);  // along the line of a side
  expect_miss(vertex_triangle(vertex_at_corner_triangle({-kTiniest, -4, 0}, {-kTiniest, 4, 0})));
}

TEST(ExactVertexTriangle, CoplanarIrrationalTime) {
  // The side from the origin to (-4t, 4, 0) sweeps over (-1/2, t, 0) at t = sqrt(1/2).
  const Query q = {{{-0.5, 0, 0}, kOrigin, {4, 0, 0}, {0, 4, 0}}, {{-0.5, 1, 0}, kOrigin, {4, 0, 0}, {-4, 4, 0}}};
  const ExactImpact found = vertex_triangle(q);
  ASSERT_TRUE(found.hit);
  expect_last_double(found.toi, [](double t) { return std::fma(t, t, -0.5) <= 0; });
}

TEST(ExactVertexTriangle, CommonTranslation) {
  const Query q = vertex_at_corner_triangle({1, 1, 1}, {1, 1, -2});
  const double toi = vertex_triangle(q).toi;
  expect_impact(vertex_triangle(moved(q, {1e6, -3, 0.5}, {0x1p40, 0x1p30, -0x1p20})), toi);
  const Query alongside = vertex_at_corner_triangle({1, 1, 0x1p-20}, {1, 1, 0x1p-20});
  expect_miss(vertex_triangle(moved(alongside, kOrigin, {0x1p20, 0x1p30, 0x1p25})));
}

TEST(ExactVertexTriangle, AtRest) {
  expect_impact(vertex_triangle(vertex_at_corner_triangle({1, 1, 0}, {1, 1, 0})), 0);
  expect_impact(vertex_triangle(vertex_at_corner_triangle(kOrigin, kOrigin)), 0);
  expect_miss(vertex_triangle(vertex_at_corner_triangle({1, 1, kTiniest}, {1, 1, kTiniest})));
  expect_miss(vertex_triangle(vertex_at_corner_triangle({-kTiniest, 1, 0}, {-kTiniest, 1, 0})));
}

TEST(ExactVertexTriangle, WithoutArea) {
  const Point from{1, 1, 1}, to{1, 1, -1};
  const auto at = [&](const Point& a, const Point& b, const Point& c) {
    return vertex_triangle({{from, a, b, c}, {to, a, b, c}});
  };
  expect_impact(at({0, 0, 0}, {2, 2, 0}, {3, 3, 0}), 0.5);
  expect_impact(at({1, 1, 0}, {1, 1, 0}, {1, 1, 0}), 0.5);
  expect_impact(at({0, 1, 0}, {4, 1, 0}, {4, 1, 0}), 0.5);
  expect_miss(at({0, 1, 0}, {1 - 0x1p-53, 1, 0}, {1 - 0x1p-53, 1, 0}));
  expect_miss(at({2, 2, 0}, {2, 2, 0}, {2, 2, 0}));
}

TEST(ExactVertexTriangle, LosesItsAreaAtTheTimeOfContact) {
  // The corner c reaches the side a b at t = 1/2, as does the vertex; before, the vertex is below the triangle.
  const Query q = {{{1, 1, -1}, kOrigin, {4, 0, 0}, {1, 1, 0}}, {{1, -1, 1}, kOrigin, {4, 0, 0}, {1, -1, 0}}};
  expect_impact(vertex_triangle(q), 0.5);
}

TEST(ExactVertexTriangle, Needle) {
  const double w = 0x1p-1000;
  const auto at = [&](double y) {
    return vertex_triangle({{{1, y, 1}, kOrigin, {2, 0, 0}, {2, w, 0}}, {{1, y, -1}, kOrigin, {2, 0, 0}, {2, w, 0}}});
  };
  expect_impact(at(0), 0.5);
  expect_impact(at(w / 2), 0.5);
  expect_miss(at(std::nextafter(w / 2, w)));
  expect_miss(at(-kTiniest));
}

TEST(ExactVertexTriangle, DenormalAndHugeCoordinates) {
  const Query q = vertex_at_corner_triangle({1, 1, 1}, {1, 1, -2});
  const Query miss = vertex_at_corner_triangle({1, -1, 1}, {1, -1, -2});
  const double toi = vertex_triangle(q).toi;
  for (const int exponent : {-1074, -1022, -500, 500, 1000, 1018}) {
    expect_impact(vertex_triangle(scaled(q, exponent)), toi);
    expect_miss(vertex_triangle(scaled(miss, exponent)));
  }
}

TEST(ExactVertexTriangle, MixedScales) {
  const double big = 1e300;
  const Point b{big, 0, 0}, c{0, big, 0};
  const auto falls = [&](double x, double from, double to) {
    return vertex_triangle({{{x, 1, from}, kOrigin, b, c}, {{x, 1, to}, kOrigin, b, c}});
  };
  expect_impact(falls(1, 4 * kTiniest, -4 * kTiniest), 0.5);
  expect_impact(falls(kTiniest, big, -big), 0.5);
  expect_miss(falls(-kTiniest, big, -big));
  expect_miss(falls(1, big, kTiniest));
}

TEST(ExactVertexTriangle, ThicknessKnownTimes) {
  expect_impact(vertex_triangle(vertex_at_corner_triangle({1, 1, 2}, {1, 1, 0}, 1)), 0.5);        // over the face
  expect_impact(vertex_triangle(vertex_at_corner_triangle({2, -3, 8}, {2, -3, 0}, 5)), 0.5);      // 3, 4, 5 at a side
  expect_impact(vertex_triangle(vertex_at_corner_triangle({-3, -4, 24}, {-3, -4, 0}, 13)), 0.5);  // 5, 12, 13, corner
  expect_impact(vertex_triangle(vertex_at_corner_triangle({1, 1, 2}, {1, 1, 1}, 1)), 1);
  expect_impact(vertex_triangle(vertex_at_corner_triangle({1, 1, 1}, {1, 1, 9}, 1)), 0);
  expect_miss(vertex_triangle(vertex_at_corner_triangle({1, 1, 2}, {1, 1, std::nextafter(1.0, 2.0)}, 1)));
  expect_miss(vertex_triangle(vertex_at_corner_triangle({-3, -4, 24}, {-3, -4, 0}, std::nextafter(5.0, 0.0))));
  expect_impact(vertex_triangle(vertex_at_corner_triangle({-3, -4, 24}, {-3, -4, 0}, 5)), 1);
}

TEST(ExactVertexTriangle, ThicknessIrrationalTime) {
  // Distance^2 to the side is 1 + (2 - 2t)^2, which is 4 at t = 1 - sqrt(3) / 2.
  const ExactImpact found = vertex_triangle(vertex_at_corner_triangle({2, -1, 2}, {2, -1, 0}, 2));
  ASSERT_TRUE(found.hit);
  expect_last_double(found.toi, [](double t) {
    return (2 - 2 * static_cast<long double>(t)) * (2 - 2 * static_cast<long double>(t)) >= 3;
  });
}

TEST(ExactVertexTriangle, ThicknessGrazes) {
  // Passes the corner at the distance 5, closest at t = 1/2.
  expect_impact(vertex_triangle(vertex_at_corner_triangle({-3, -4, 4}, {-3, -4, -4}, 5)), 0.5);
  expect_miss(vertex_triangle(vertex_at_corner_triangle({-3, -4, 4}, {-3, -4, -4}, std::nextafter(5.0, 0.0))));
}

TEST(ExactVertexTriangle, ThicknessOfATriangleWithoutArea) {
  const Point a{0, 0, 0}, b{4, 0, 0};
  expect_impact(vertex_triangle({{{2, 3, 8}, a, b, b}, {{2, 3, 0}, a, b, b}, 5}), 0.5);
  expect_impact(vertex_triangle({{{-3, 4, 24}, a, a, a}, {{-3, 4, 0}, a, a, a}, 13}), 0.5);
  expect_miss(vertex_triangle({{{2, 6, 8}, a, b, b}, {{2, 6, -8}, a, b, b}, 5}));
}

TEST(ExactEdgeEdge, KnownTimes) {
  expect_impact(edge_edge(crossing_edges(1, -1)), 0.5);
  expect_impact(edge_edge(crossing_edges(0, 3)), 0);
  expect_impact(edge_edge(crossing_edges(3, 0)), 1);
  expect_miss(edge_edge(crossing_edges(3, kTiniest)));
  expect_last_double(edge_edge(crossing_edges(1, -2)).toi, [](double t) { return std::fma(3, t, -1) <= 0; });
}

TEST(ExactEdgeEdge, IrrationalTime) {
  // a runs along (1, 0, t) through the origin, b along y through (t, 0, 1/2): they cross where t^2 = 1/2.
  const Query q = {{{-1, 0, 0}, {1, 0, 0}, {0, -1, 0.5}, {0, 1, 0.5}},
                   {{-1, 0, -1}, {1, 0, 1}, {1, -1, 0.5}, {1, 1, 0.5}}};
  const ExactImpact found = edge_edge(q);
  ASSERT_TRUE(found.hit);
  expect_last_double(found.toi, [](double t) { return std::fma(t, t, -0.5) <= 0; });
}

TEST(ExactEdgeEdge, CoplanarTwiceAndMeetingTheSecondTime) {
  // As above through (1 - t, y, 3/16): 3/16 = t (1 - t) at 1/4 and 3/4, but at 1/4 b is beside a.
  const Query q = {{{-1, 0, 0}, {1, 0, 0}, {1, 2, 0.1875}, {1, 3, 0.1875}},
                   {{-1, 0, -1}, {1, 0, 1}, {0, -1, 0.1875}, {0, 0, 0.1875}}};
  expect_impact(edge_edge(q), 0.75);
  expect_impact(edge_edge(reversed(q)), 0.25);
}

TEST(ExactEdgeEdge, EndsMeetOrPassByOneUlp) {
  const auto passes = [](double x) {
    return edge_edge({{{-1, 0, 0}, {0, 0, 0}, {x, 0, 1}, {x, 1, 1}}, {{-1, 0, 0}, {0, 0, 0}, {x, 0, -1}, {x, 1, -1}}});
  };
  expect_impact(passes(0), 0.5);
  expect_miss(passes(kTiniest));
}

TEST(ExactEdgeEdge, Parallel) {
  const Point a0{0, 0, 0}, a1{1, 0, 0};
  const auto moves = [&](const Point& b0, const Point& b1, const Point& by) {
    return edge_edge({{a0, a1, b0, b1}, {a0, a1, b0 + by, b1 + by}});
  };
  expect_impact(moves({1, 0, 0}, {2, 0, 0}, kOrigin), 0);            // collinear, touching
  expect_miss(moves({1 + 0x1p-52, 0, 0}, {2, 0, 0}, kOrigin));       // collinear, disjoint
  expect_impact(moves({2, 0, 0}, {3, 0, 0}, {-2, 0, 0}), 0.5);       // collinear, approaching
  expect_impact(moves({2, 0, 0}, {3, 0, 0}, {-1, 0, 0}), 1);         // collinear, touching at the end
  expect_impact(moves({-1, 0, 2}, {3, 0, 2}, {0, 0, -4}), 0.5);      // over all of its length
  expect_miss(moves({-1, 0, 2}, {3, 0, 2}, {0, 0, -2 + 0x1p-52}));   // just not
  expect_impact(moves({-5, 1, 1}, {-4, 1, 1}, {16, -4, -4}), 0.25);  // falls from beside onto the line, at x = -1..0
}

TEST(ExactEdgeEdge, ParallelOnlyForAMoment) {
  // b turns about its middle in the plane of a; its end comes to lie on a as b becomes parallel to a at t = 1/2.
  const Query q = {{{0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {3, 2, 0}}, {{0, 0, 0}, {4, 0, 0}, {1, -1, 0}, {3, -2, 0}}};
  expect_impact(edge_edge(q), 0.5);
}

TEST(ExactEdgeEdge, WithoutLength) {
  const Point a0{0, 0, 0}, a1{2, 0, 0};
  expect_impact(edge_edge({{a0, a1, {1, 0, 1}, {1, 0, 1}}, {a0, a1, {1, 0, -1}, {1, 0, -1}}}), 0.5);
  expect_impact(edge_edge({{a0, a0, {0, 0, 1}, {0, 0, 1}}, {a0, a0, {0, 0, -1}, {0, 0, -1}}}), 0.5);
  expect_miss(
      edge_edge({{a0, a1, {-kTiniest, 0, 1}, {-kTiniest, 0, 1}}, {a0, a1, {-kTiniest, 0, -1}, {-kTiniest, 0, -1}}}));
}

TEST(ExactEdgeEdge, ThicknessKnownTimes) {
  expect_impact(edge_edge(crossing_edges(3, -1, 1)), 0.5);
  expect_miss(edge_edge(crossing_edges(3, std::nextafter(1.0, 2.0), 1)));
  const Point a0{0, 0, 0}, a1{1, 0, 0};
  // An end beside an edge: 3, 4, 5. Two ends: 2, 3, 6, 7. Parallel, one above the other.
  expect_impact(edge_edge({{a0, a1, {0.5, 3, 8}, {0.5, 9, 8}}, {a0, a1, {0.5, 3, 0}, {0.5, 9, 0}}, 5}), 0.5);
  expect_impact(edge_edge({{a0, a1, {3, 3, 12}, {9, 3, 12}}, {a0, a1, {3, 3, 0}, {9, 3, 0}}, 7}), 0.5);
  expect_impact(edge_edge({{a0, a1, {-9, 0, 3}, {9, 0, 3}}, {a0, a1, {-9, 0, 1}, {9, 0, 1}}, 2}), 0.5);
}

TEST(ExactEdgeEdge, DenormalAndHugeCoordinates) {
  const double toi = edge_edge(crossing_edges(1, -2)).toi;
  for (const int exponent : {-1074, -1022, 500, 1018})
    expect_impact(edge_edge(scaled(crossing_edges(1, -2), exponent)), toi);
}

}  // namespace
}  // namespace collided::test
