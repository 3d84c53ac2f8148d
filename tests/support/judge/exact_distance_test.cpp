// Distances known by hand, and contact at a distance against samples of the distance.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/distance.hpp"
#include "tests/support/judge/exact_judge.hpp"

namespace collided::test {
namespace {

const std::array<Vec3d, 3> kTriangle{Vec3d{0, 0, 0}, Vec3d{4, 0, 0}, Vec3d{0, 4, 0}};

bool near_triangle(const Vec3d& v, double thickness) {
  return judge_proximity(QueryKind::kVertexTriangle, {v, kTriangle[0], kTriangle[1], kTriangle[2]}, thickness);
}

// The vertex `v` moves to `to`; the triangle stands still.
ExactImpact approach(const Vec3d& v, const Vec3d& to, double thickness) {
  const auto& [a, b, c] = kTriangle;
  return judge_ccd({QueryKind::kVertexTriangle, {v, a, b, c, to, a, b, c}}, thickness);
}

void expect_time(const ExactImpact& impact, const mpq_class& time) {
  ASSERT_TRUE(impact.hit);
  EXPECT_LE(impact.lower, time);
  EXPECT_GE(impact.upper, time);
  EXPECT_LE(mpq_class((impact.upper - impact.lower) * mpq_class(mpz_class(1) << 60)), 1);
}

void expect_within(const ExactImpact& impact, double low, double high) {
  ASSERT_TRUE(impact.hit);
  EXPECT_GE(impact.lower, low);
  EXPECT_LE(impact.upper, high);
}

// The part of the triangle that is closest: inside, side, corner; distances are whole numbers.
TEST(ExactProximity, VertexAndTriangle) {
  struct Fact {
    Vec3d vertex;
    double distance;
  };
  for (const Fact& fact : {Fact{{1, 1, 3}, 3}, Fact{{1, -3, 4}, 5}, Fact{{-3, -4, 12}, 13},
                           Fact{{5, 5, 0}, 3 * M_SQRT2}, Fact{{6, -3, 6}, 7}, Fact{{-2, 2, 0}, 2}}) {
    EXPECT_TRUE(near_triangle(fact.vertex, fact.distance * (1 + 0x1p-50)));
    EXPECT_FALSE(near_triangle(fact.vertex, fact.distance * (1 - 0x1p-50)));
    if (fact.distance != std::floor(fact.distance)) continue;
    EXPECT_TRUE(near_triangle(fact.vertex, fact.distance));
  }
}

TEST(ExactProximity, EdgeAndEdge) {
  const auto near = [](const std::array<Vec3d, 4>& p, double h) { return judge_proximity(QueryKind::kEdgeEdge, p, h); };
  const auto exactly = [&](const std::array<Vec3d, 4>& p, double h) {
    return near(p, h) && !near(p, h * (1 - 0x1p-52));
  };
  EXPECT_TRUE(exactly({Vec3d{-1, 0, 0}, {1, 0, 0}, {0, -1, 3}, {0, 1, 3}}, 3));    // across
  EXPECT_TRUE(exactly({Vec3d{-1, 0, 0}, {1, 0, 0}, {0, 3, 4}, {0, 9, 4}}, 5));     // an end and an inside
  EXPECT_TRUE(exactly({Vec3d{-1, 0, 0}, {1, 0, 0}, {4, 4, 12}, {9, 9, 12}}, 13));  // two ends
  EXPECT_TRUE(exactly({Vec3d{-1, 0, 0}, {1, 0, 0}, {0, 3, 4}, {5, 3, 4}}, 5));     // parallel
  EXPECT_TRUE(exactly({Vec3d{-1, 0, 0}, {1, 0, 0}, {3, 0, 0}, {5, 0, 0}}, 2));     // on one line
  EXPECT_TRUE(exactly({Vec3d{2, 3, 6}, {2, 3, 6}, {0, 0, 0}, {0, 0, 0}}, 7));      // two points
}

TEST(ExactProximity, ThicknessZeroIsContact) {
  EXPECT_TRUE(near_triangle({1, 1, 0}, 0));
  EXPECT_TRUE(near_triangle({4, 0, 0}, 0));
  EXPECT_FALSE(near_triangle({1, 1, 0x1p-1074}, 0));
  EXPECT_TRUE(near_triangle({1, 1, 0x1p-1074}, 0x1p-1074));
  EXPECT_FALSE(near_triangle({1, 1, 0x1p-1073}, 0x1p-1074));
}

TEST(ExactDistance, VertexComesNear) {
  expect_time(approach({1, 1, 7}, {1, 1, -7}, 1), mpq_class(3, 7));
  expect_time(approach({1, 1, 7}, {1, 1, 1}, 1), 1);
  EXPECT_FALSE(approach({1, 1, 7}, {1, 1, 1 + 0x1p-52}, 1).hit);
  expect_time(approach({1, 1, 1}, {1, 1, 9}, 1), 0);
  expect_time(approach({1, 1, 0.5}, {1, 1, 9}, 1), 0);
  expect_time(approach({1, 1, 7}, {1, 1, -7}, 0), mpq_class(1, 2));
}

// Past a corner at distance 3 along a line: 5 from it where it has 4 to go; and touching the ball of radius 3 only.
TEST(ExactDistance, VertexComesNearACorner) {
  expect_time(approach({-8, -3, 0}, {0, -3, 0}, 5), mpq_class(1, 2));
  expect_time(approach({-8, -3, -8}, {8, -3, 8}, 3), mpq_class(1, 2));
  EXPECT_FALSE(approach({-8, -3, -8}, {8, -3, 8}, 3 - 0x1p-51).hit);
  // Its square is 9 + 512 (t - 1/2)^2.
  const double time = 0.5 - std::sqrt(1.0 / 512);
  expect_within(approach({-8, -3, -8}, {8, -3, 8}, std::sqrt(10.0)), time - 1e-12, time + 1e-12);
}

// The vertex keeps its distance to the plane, or to the line of a side, and comes over the triangle at t = 1/4.
TEST(ExactDistance, GapThatNeverChanges) {
  const double h = 2;
  const ExactImpact over = approach({-1, 1, h}, {3, 1, h}, h);
  expect_time(over, mpq_class(1, 4));
  const ExactImpact along = approach({-1, -h, 0}, {3, -h, 0}, h);
  expect_time(along, mpq_class(1, 4));
  EXPECT_FALSE(approach({-1, 1, h + 0x1p-51}, {3, 1, h + 0x1p-51}, h).hit);
}

TEST(ExactDistance, EdgesComeNear) {
  const auto across = [](double from, double to, double h) {
    return judge_ccd(
        {QueryKind::kEdgeEdge,
         {Vec3d{-1, 0, from}, {1, 0, from}, {0, -1, 0}, {0, 1, 0}, {-1, 0, to}, {1, 0, to}, {0, -1, 0}, {0, 1, 0}}},
        h);
  };
  expect_time(across(7, -7, 1), mpq_class(3, 7));
  expect_time(across(7, 1, 1), 1);
  EXPECT_FALSE(across(7, 1 + 0x1p-52, 1).hit);
}

double distance_at(const Query& q, double t) {
  std::array<Vec3d, 4> x;
  for (int i = 0; i < 4; ++i) x[i] = lerp(q.p[i], q.p[i + 4], t);
  if (q.kind == QueryKind::kVertexTriangle) return point_triangle(x[0], {x[1], x[2], x[3]}).distance;
  return edge_edge({x[0], x[1]}, {x[2], x[3]}).distance;
}

// Random motions: before the judge's time no sample is within the thickness, at it the distance is the thickness.
TEST(ExactDistance, AgreesWithSamplesOfTheDistance) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1, 1), width(0.05, 0.4);
  size_t hits = 0;
  for (int n = 0; n < 2000; ++n) {
    Query q{n % 2 ? QueryKind::kVertexTriangle : QueryKind::kEdgeEdge, {}};
    for (int i = 0; i < 24; ++i) q.p[i / 3][i % 3] = coordinate(random);
    const double h = width(random);
    const ExactImpact impact = judge_ccd(q, h);
    hits += impact.hit;
    const double time = impact.hit ? impact.lower.get_d() : 1;
    ASSERT_LE(distance_at(q, time), impact.hit ? h + 1e-9 : 10) << n;
    if (time == 0) continue;
    for (int i = 0; i <= 64; ++i) ASSERT_GT(distance_at(q, time * i / 64), h - 1e-9) << n;
  }
  std::printf("2,000 random motions: %zu come within their thickness\n", hits);
  EXPECT_GT(hits, 500u);
}

}  // namespace
}  // namespace collided::test
