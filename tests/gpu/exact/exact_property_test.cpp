// What holds for any query, on small integers, where contacts and degenerate features are frequent.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "gpu/exact/exact.hpp"
#include "gpu/narrow/distance.hpp"
#include "tests/gpu/exact/queries.hpp"

namespace collided::test {
namespace {

constexpr int kQueries = 500;
constexpr double kThicknesses[] = {0, 0, 0.5, 1};

struct Kind {
  Impact impact;
  Proximity near;
  Closest<double> (*closest)(const Point&, const Point&, const Point&, const Point&);
  int orders[3][4];  ///< that leave the features what they are
};

const Kind kKinds[] = {
    {ccd<ContactKind::kVertexTriangle>,
     proximity<ContactKind::kVertexTriangle>,
     closest_vertex_triangle<double>,
     {{0, 2, 3, 1}, {0, 3, 2, 1}, {0, 2, 1, 3}}},
    {ccd<ContactKind::kEdgeEdge>,
     proximity<ContactKind::kEdgeEdge>,
     closest_edge_edge<double>,
     {{2, 3, 0, 1}, {1, 0, 2, 3}, {3, 2, 1, 0}}},
};

/// Coordinates -2 to 2; some points in the plane z = 0 all the time, some at rest.
Query random_query(std::mt19937& random) {
  std::uniform_int_distribution<int> integer(-2, 2), one_in_four(0, 3);
  const bool flat = one_in_four(random) == 0;
  const auto point = [&] {
    const double x = integer(random), y = integer(random), z = integer(random);
    return Point{x, y, flat ? 0 : z};
  };
  Query q;
  for (int i = 0; i < 4; ++i) {
    q.start[i] = point();
    q.end[i] = one_in_four(random) == 0 ? q.start[i] : point();
  }
  q.thickness = kThicknesses[one_in_four(random)];
  return q;
}

template <class Check>
void for_each_query(Check check) {
  std::mt19937 random(17);
  for (int i = 0; i < kQueries; ++i) {
    const Query q = random_query(random);
    for (const Kind& kind : kKinds) check(kind, q);
    if (testing::Test::HasFailure()) return;
  }
}

void expect_same(const ExactImpact& a, const ExactImpact& b) {
  EXPECT_EQ(a.hit, b.hit);
  EXPECT_EQ(a.toi, b.toi);
}

TEST(ExactProperties, OrderOfTheCornersAndEdgesDoesNotMatter) {
  for_each_query([](const Kind& kind, const Query& q) {
    for (const auto& order : kind.orders) expect_same(impact(kind.impact, permuted(q, order)), impact(kind.impact, q));
  });
}

TEST(ExactProperties, UnitAndOriginDoNotMatter) {
  for_each_query([](const Kind& kind, const Query& q) {
    const ExactImpact found = impact(kind.impact, q);
    expect_same(impact(kind.impact, scaled(q, -1073)), found);
    expect_same(impact(kind.impact, scaled(q, 1000)), found);
    expect_same(impact(kind.impact, moved(q, {0x1p40, 3, -7}, {5, -0x1p35, 0x1p20})), found);
  });
}

TEST(ExactProperties, TimeReversedTheAnswerStays) {
  for_each_query([](const Kind& kind, const Query& q) {
    EXPECT_EQ(impact(kind.impact, reversed(q)).hit, impact(kind.impact, q).hit);
  });
}

TEST(ExactProperties, TheFirstHalfOfTheMotionComesFirst) {
  for_each_query([](const Kind& kind, const Query& q) {
    const ExactImpact whole = impact(kind.impact, q);
    const ExactImpact first = impact(kind.impact, part(q, 0, 0.5)), second = impact(kind.impact, part(q, 0.5, 1));
    EXPECT_EQ(whole.hit, first.hit || second.hit);
    if (whole.hit) {
      EXPECT_NEAR(whole.toi, first.hit ? first.toi / 2 : 0.5 + second.toi / 2, 0x1p-53);
    }
  });
}

TEST(ExactProperties, NoSampleIsNearBeforeTheImpact) {
  for_each_query([](const Kind& kind, const Query& q) {
    const ExactImpact found = impact(kind.impact, q);
    for (int i = 0; i <= 8; ++i) {
      const double t = i / 8.0;
      if (kind.near(part(q, t, t).start, q.thickness)) {
        EXPECT_TRUE(found.hit);
        EXPECT_LE(found.toi, t);
      }
    }
  });
}

TEST(ExactProperties, FeaturesAreNearAtTheImpact) {
  for_each_query([](const Kind& kind, const Query& q) {
    const ExactImpact found = impact(kind.impact, q);
    if (!found.hit) return;
    const Query at = part(q, found.toi, found.toi);
    const auto& p = at.start;
    EXPECT_LE(std::sqrt(kind.closest(p[0], p[1], p[2], p[3]).squared), q.thickness + 1e-13);
  });
}

/// Features that meet in the origin at t = 1/3, often with their outlines, and move by integers.
Query meeting_query(std::mt19937& random, bool vertex_triangle) {
  std::uniform_int_distribution<int> integer(-2, 2), weight(0, 2);
  const auto vector = [&] {
    const double x = integer(random), y = integer(random), z = integer(random);
    return Point{x, y, z};
  };
  const Point p = vector(), q = vector();
  const double u = -weight(random), v = -weight(random);
  const Point meeting[2][4] = {{p, u * p, q, v * q}, {kOrigin, p, q, u * p + v * q}};
  Query made;
  for (int i = 0; i < 4; ++i) {
    const Point third = vector();
    made.start[i] = meeting[vertex_triangle][i] - third;
    made.end[i] = meeting[vertex_triangle][i] + 2.0 * third;
  }
  return made;
}

TEST(ExactProperties, AContactAtAThirdIsFound) {
  std::mt19937 random(18);
  for (int i = 0; i < 2 * kQueries; ++i) {
    for (const bool is_vertex_triangle : {true, false}) {
      const Query q = meeting_query(random, is_vertex_triangle);
      const ExactImpact found = is_vertex_triangle ? vertex_triangle(q) : edge_edge(q);
      ASSERT_TRUE(found.hit);
      EXPECT_LE(std::fma(3, found.toi, -1), 0);
    }
  }
}

TEST(ExactProperties, ThickerIsNotLater) {
  for_each_query([](const Kind& kind, Query q) {
    const ExactImpact thin = impact(kind.impact, q);
    q.thickness += 0x1p-30;
    const ExactImpact thick = impact(kind.impact, q);
    EXPECT_TRUE(thick.hit || !thin.hit);
    EXPECT_LE(thick.toi, thin.toi);
  });
}

TEST(ExactProperties, AtRestImpactIsProximity) {
  for_each_query([](const Kind& kind, const Query& q) {
    const ExactImpact found = kind.impact(q.start, q.start, q.thickness);
    EXPECT_EQ(found.hit, kind.near(q.start, q.thickness));
    EXPECT_EQ(found.toi, found.hit ? 0 : 1);
  });
}

}  // namespace
}  // namespace collided::test
