// Contacts whose time is known by hand, and invariances of the answer.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <stdexcept>

#include "tests/support/judge/exact_distance.hpp"
#include "tests/support/labelled/labelled.hpp"

namespace collided::test {
namespace {

constexpr double kUlp = 0x1p-52;

Query moving(QueryKind kind, const std::array<Vec3d, 4>& start, const std::array<Vec3d, 4>& end) {
  return {kind, {start[0], start[1], start[2], start[3], end[0], end[1], end[2], end[3]}};
}

// A vertex that moves past a triangle with the corners (0,0,0), (1,0,0), (0,1,0).
Query vertex_moves(const Vec3d& from, const Vec3d& to) {
  return moving(QueryKind::kVertexTriangle, {from, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                {to, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
}

// An edge along y through (x, 0, z) that moves past the edge from (-1,0,0) to (1,0,0).
Query edge_moves(const Vec3d& from, const Vec3d& to) {
  const auto end = [](Vec3d p, double y) { return Vec3d{p[0], p[1] + y, p[2]}; };
  return moving(QueryKind::kEdgeEdge, {end(from, -1), end(from, 1), {-1, 0, 0}, {1, 0, 0}},
                {end(to, -1), end(to, 1), {-1, 0, 0}, {1, 0, 0}});
}

void expect_time(const Query& query, const mpq_class& time) {
  const ExactImpact impact = judge_ccd(query);
  ASSERT_TRUE(impact.hit);
  EXPECT_LE(impact.lower, time);
  EXPECT_GE(impact.upper, time);
  EXPECT_LE(mpq_class((impact.upper - impact.lower) * mpq_class(mpz_class(1) << 60)), 1);
}

void expect_miss(const Query& query) { EXPECT_FALSE(judge_ccd(query).hit); }

TEST(ExactJudge, VertexMeetsTriangle) {
  expect_time(vertex_moves({0.25, 0.25, 1}, {0.25, 0.25, -1}), mpq_class(1, 2));
  expect_time(vertex_moves({0.25, 0.25, 1}, {0.25, 0.25, -2}), mpq_class(1, 3));
  expect_miss(vertex_moves({0.75, 0.75, 1}, {0.75, 0.75, -1}));
  expect_miss(vertex_moves({0.25, 0.25, 1}, {0.25, 0.25, 0x1p-1074}));
}

TEST(ExactJudge, EdgesMeet) {
  expect_time(edge_moves({0, 0, 1}, {0, 0, -2}), mpq_class(1, 3));
  expect_miss(edge_moves({1.25, 0, 1}, {1.25, 0, -2}));
  expect_miss(edge_moves({0, 0, 1}, {0, 0, 0x1p-1074}));
}

TEST(ExactJudge, BothEndsOfTimeCount) {
  expect_time(vertex_moves({0.25, 0.25, 0}, {0.25, 0.25, 1}), 0);
  expect_time(vertex_moves({0.25, 0.25, 1}, {0.25, 0.25, 0}), 1);
  expect_time(edge_moves({0, 0, 0}, {0, 0, 1}), 0);
  expect_time(edge_moves({0, 0, 1}, {0, 0, 0}), 1);
  EXPECT_EQ(judge_ccd(vertex_moves({0.25, 0.25, 1}, {0.25, 0.25, 0})).lower, 1);
}

TEST(ExactJudge, BoundariesCountAndOneUlpBeyondDoesNot) {
  for (const Vec3d& on : {Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0.5, 0.5, 0}, Vec3d{0, 0.5, 0}})
    expect_time(vertex_moves({on[0], on[1], 1}, {on[0], on[1], -3}), mpq_class(1, 4));
  for (const Vec3d& off : {Vec3d{-0x1p-1074, 0.5, 0}, Vec3d{0.5, 0.5 + kUlp, 0}, Vec3d{0.5, -0x1p-1074, 0}})
    expect_miss(vertex_moves({off[0], off[1], 1}, {off[0], off[1], -3}));
  expect_time(edge_moves({1, 1, 1}, {1, 1, -1}), mpq_class(1, 2));
  expect_miss(edge_moves({1 + kUlp, 1, 1}, {1 + kUlp, 1, -1}));
  expect_miss(edge_moves({1, 1 + 2 * kUlp, 1}, {1, 1 + 2 * kUlp, -1}));
}

// The triangle's plane rises as t, and bends: z = t (x + 1) - 1/2 at the vertex, which moves as x = t: t^2 + t = 1/2.
TEST(ExactJudge, IrrationalTime) {
  const Query q = moving(QueryKind::kVertexTriangle, {Vec3d{0, 0, 0.5}, {-1, -5, 0}, {-1, 5, 0}, {5, 0, 0}},
                         {Vec3d{1, 0, 0.5}, {-1, -5, 0}, {-1, 5, 0}, {5, 0, 6}});
  const ExactImpact impact = judge_ccd(q);
  ASSERT_TRUE(impact.hit);
  const auto below = [](const mpq_class& t) { return mpq_class(t * t + t) <= mpq_class(1, 2); };
  EXPECT_TRUE(below(impact.lower));
  EXPECT_FALSE(below(impact.upper));
  EXPECT_LT(impact.upper - impact.lower, 1e-18);
}

TEST(ExactJudge, StandingStill) {
  expect_time(vertex_moves({0.25, 0.25, 0}, {0.25, 0.25, 0}), 0);
  expect_miss(vertex_moves({0.25, 0.25, 0x1p-1074}, {0.25, 0.25, 0x1p-1074}));
  expect_time(edge_moves({0.5, 0, 0}, {0.5, 0, 0}), 0);
  expect_miss(edge_moves({0.5, 0, 0x1p-1074}, {0.5, 0, 0x1p-1074}));
}

TEST(ExactJudge, IdenticallyCoplanar) {
  expect_time(vertex_moves({-1, 0.25, 0}, {1, 0.25, 0}), mpq_class(1, 2));
  expect_time(vertex_moves({-1, -1, 0}, {2, 2, 0}), mpq_class(1, 3));  // at the corner
  expect_miss(vertex_moves({-1, 0.25, 0}, {-1, 1, 0}));
  expect_time(edge_moves({0.5, -3, 0}, {0.5, -1, 0}), 1);
  expect_time(edge_moves({2, 0, 0}, {-1, 0, 0}), mpq_class(1, 3));
  expect_miss(edge_moves({0.5, -3, 0}, {0.5, -1.5, 0}));
}

TEST(ExactJudge, TrianglesWithoutArea) {
  const Vec3d o{0, 0, 0}, x{1, 0, 0}, y{0, 1, 0};
  const auto meets = [](const Vec3d& from, const Vec3d& to, const std::array<Vec3d, 3>& t) {
    return moving(QueryKind::kVertexTriangle, {from, t[0], t[1], t[2]}, {to, t[0], t[1], t[2]});
  };
  expect_time(meets({0.5, 0, 1}, {0.5, 0, -1}, {o, x, x}), mpq_class(1, 2));
  expect_time(meets({0.5, 0, 1}, {0.5, 0, -1}, {o, o, x}), mpq_class(1, 2));
  expect_time(meets({0.5, 0, 1}, {0.5, 0, -1}, {Vec3d{0.25, 0, 0}, o, x}), mpq_class(1, 2));
  expect_miss(meets({1.5, 0, 1}, {1.5, 0, -1}, {o, x, x}));
  expect_time(meets({0, 1, 1}, {0, 1, -2}, {y, y, y}), mpq_class(1, 3));
  expect_miss(meets({0, 1, 1}, {0, 1 + kUlp, -2}, {y, y, y}));
  expect_time(meets(y, y, {y, y, y}), 0);
}

TEST(ExactJudge, EdgesWithoutLength) {
  const auto points = [](const Vec3d& from, const Vec3d& to) {
    return moving(QueryKind::kEdgeEdge, {from, from, {-1, 0, 0}, {1, 0, 0}}, {to, to, {-1, 0, 0}, {1, 0, 0}});
  };
  expect_time(points({0.5, 0, 1}, {0.5, 0, -2}), mpq_class(1, 3));
  expect_miss(points({1.5, 0, 1}, {1.5, 0, -2}));
  expect_time(moving(QueryKind::kEdgeEdge, {Vec3d{0, 0, 1}, {0, 0, 1}, {}, {}}, {Vec3d{0, 0, -2}, {0, 0, -2}, {}, {}}),
              mpq_class(1, 3));
  expect_miss(moving(QueryKind::kEdgeEdge, {Vec3d{0, 0, 1}, {0, 0, 1}, {}, {}}, {Vec3d{1, 0, -2}, {1, 0, -2}, {}, {}}));
}

TEST(ExactJudge, ParallelEdges) {
  const auto shifted = [](double from, double to, double z0, double z1) {
    return moving(QueryKind::kEdgeEdge, {Vec3d{from, 0, z0}, {to, 0, z0}, {0, 0, 0}, {1, 0, 0}},
                  {Vec3d{from, 0, z1}, {to, 0, z1}, {0, 0, 0}, {1, 0, 0}});
  };
  expect_time(shifted(0.25, 0.5, 1, -1), mpq_class(1, 2));
  expect_time(shifted(-1, 2, 1, -1), mpq_class(1, 2));
  expect_time(shifted(1, 2, 1, -1), mpq_class(1, 2));
  expect_miss(shifted(1 + kUlp, 2, 1, -1));
}

// At t = 1/2 the triangle is a segment for one moment, and the vertex meets it then.
TEST(ExactJudge, TriangleThatFoldsForAMoment) {
  const auto folding = [](double x) {
    return moving(QueryKind::kVertexTriangle, {Vec3d{x, 0, 1}, {0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}},
                  {Vec3d{x, 0, -1}, {0, 0, 0}, {1, 0, 0}, {0.5, -1, 0}});
  };
  expect_time(folding(0.75), mpq_class(1, 2));
  expect_miss(folding(1.25));
}

TEST(ExactJudge, MotionTogetherChangesNothing) {
  Query q = vertex_moves({0.25, 0.25, 1}, {0.25, 0.25, -2});
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 3; ++k) q.p[i][k] += 0x1p30 + (i < 4 ? 0 : 0x1p40 * (k + 1));
  expect_time(q, mpq_class(1, 3));
}

TEST(ExactJudge, RefusesWhatIsNoNumber) {
  for (const double bad : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    Query q = vertex_moves({0.25, 0.25, 1}, {0.25, 0.25, -1});
    EXPECT_THROW(judge_ccd(q, bad), std::invalid_argument);
    q.p[5][1] = bad;
    EXPECT_THROW(judge_ccd(q), std::invalid_argument);
  }
  EXPECT_THROW(judge_ccd(vertex_moves({}, {}), -1), std::invalid_argument);
}

// --- Our own labelled set, and invariances of the answer -----------------------------------------------------------

class ExactJudgeLabelled : public ::testing::Test {
 protected:
  const std::vector<LabelledQuery> queries_ = read_labelled_set(labelled_set());
};

TEST_F(ExactJudgeLabelled, AgreesWithOurOwnSet) {
  size_t disagree = 0;
  for (const LabelledQuery& label : queries_) {
    if (agrees(judge_ccd(label.query), label)) continue;
    ++disagree;
    ADD_FAILURE() << label.family;
  }
  std::printf("%zu queries: %zu disagree\n", queries_.size(), disagree);
  EXPECT_EQ(queries_.size(), 2400u);
}

// Neither interval is wholly before the other.
bool same(const ExactImpact& a, const ExactImpact& b) {
  if (a.hit != b.hit) return false;
  return !a.hit || (a.lower <= b.upper && b.lower <= a.upper);
}

Query reordered(const Query& q, const std::array<int, 4>& order) {
  Query r = q;
  for (int i = 0; i < 8; ++i) r.p[i] = q.p[order[i % 4] + i / 4 * 4];
  return r;
}

TEST_F(ExactJudgeLabelled, OrderOfCornersAndEdges) {
  for (const LabelledQuery& label : queries_) {
    const ExactImpact impact = judge_ccd(label.query);
    const bool vertex = label.query.kind == QueryKind::kVertexTriangle;
    const auto orders = vertex ? std::vector<std::array<int, 4>>{{0, 2, 1, 3}, {0, 2, 3, 1}, {0, 3, 2, 1}}
                               : std::vector<std::array<int, 4>>{{2, 3, 0, 1}, {1, 0, 2, 3}, {3, 2, 0, 1}};
    for (const auto& order : orders)
      EXPECT_TRUE(same(impact, judge_ccd(reordered(label.query, order)))) << label.family;
  }
}

TEST_F(ExactJudgeLabelled, BackwardsHitsToo) {
  for (const LabelledQuery& label : queries_) {
    Query back = label.query;
    for (int i = 0; i < 4; ++i) std::swap(back.p[i], back.p[i + 4]);
    const ExactImpact impact = judge_ccd(label.query), reversed = judge_ccd(back);
    ASSERT_EQ(impact.hit, reversed.hit) << label.family;
    // The last contact is not before the first.
    if (!impact.hit) continue;
    EXPECT_LE(impact.lower, mpq_class(1 - reversed.lower)) << label.family;
  }
}

TEST_F(ExactJudgeLabelled, PowersOfTwo) {
  for (const LabelledQuery& label : queries_)
    for (const int exponent : {-1, 70}) {
      Query scaled = label.query;
      bool exact = true;
      for (int i = 0; i < 24; ++i) {
        double& value = scaled.p[i / 3][i % 3];
        const double before = value;
        value = std::ldexp(value, exponent);
        exact = exact && std::ldexp(value, -exponent) == before;
      }
      if (!exact) continue;
      EXPECT_TRUE(same(judge_ccd(label.query), judge_ccd(scaled))) << label.family;
    }
}

TEST_F(ExactJudgeLabelled, Translation) {
  size_t moved = 0;
  for (const LabelledQuery& label : queries_) {
    Query there = label.query;
    bool exact = true;
    for (int i = 0; i < 24; ++i) {
      double& value = there.p[i / 3][i % 3];
      const double before = value, by = i % 3 * 0x1p10 + 0x1p20;
      value += by;
      exact = exact && mpq_class(value) == mpq_class(mpq_class(before) + mpq_class(by));
    }
    if (!exact) continue;
    ++moved;
    EXPECT_TRUE(same(judge_ccd(label.query), judge_ccd(there))) << label.family;
  }
  EXPECT_GT(moved, queries_.size() / 2);
}

// The cubic and the distance methods share no polynomial except the normal's.
TEST_F(ExactJudgeLabelled, ContactAsADistanceOfZero) {
  std::vector<Query> queries;
  for (const LabelledQuery& label : queries_) queries.push_back(label.query);
  std::mt19937 random(3);
  for (int n = 0; n < 4000; ++n) {
    std::uniform_int_distribution<int> coordinate(-1 - n % 3, 1 + n % 3);
    queries.push_back({n % 2 ? QueryKind::kVertexTriangle : QueryKind::kEdgeEdge, {}});
    for (int i = 0; i < 24; ++i) queries.back().p[i / 3][i % 3] = coordinate(random);
  }
  size_t hits = 0;
  for (const Query& query : queries) {
    const ExactImpact contact = judge_ccd(query);
    hits += contact.hit;
    EXPECT_TRUE(same(contact, first_time_within(exact_query(query, 0))));
  }
  std::printf("%zu queries, %zu hits, both ways\n", queries.size(), hits);
}

// Within a hair's breadth is decided by other polynomials than contact is.
TEST_F(ExactJudgeLabelled, AHairsBreadthIsNoLater) {
  for (const LabelledQuery& label : queries_) {
    const ExactImpact contact = judge_ccd(label.query), within = judge_ccd(label.query, 0x1p-100);
    if (!contact.hit) continue;
    ASSERT_TRUE(within.hit) << label.family;
    EXPECT_LE(within.lower, contact.upper) << label.family;
    if (label.family != "generic_hit") continue;
    EXPECT_LT(contact.lower - within.upper, 0x1p-80);
  }
}

}  // namespace
}  // namespace collided::test
