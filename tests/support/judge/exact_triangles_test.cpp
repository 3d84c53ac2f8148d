// Triangles, edges and points that meet or do not, by hand; and on a small lattice against another method.
//
// Two convex hulls meet where 0 is in the hull of all differences of their corners, and then (Caratheodory) in the hull
// of at most four of these that are affinely independent: a sign test on small integers each.

#include <gtest/gtest.h>

#include <random>

#include "tests/support/judge/exact_judge.hpp"

namespace collided::test {
namespace {

using Triangle = std::array<Vec3d, 3>;

const Triangle kFlat{Vec3d{0, 0, 0}, Vec3d{4, 0, 0}, Vec3d{0, 4, 0}};

bool meets_flat(const Triangle& t) {
  const bool meets = judge_triangles(t, kFlat);
  EXPECT_EQ(meets, judge_triangles(kFlat, t));
  EXPECT_EQ(meets, judge_triangles({t[1], t[2], t[0]}, {kFlat[2], kFlat[1], kFlat[0]}));
  return meets;
}

TEST(ExactTriangles, Piercing) {
  EXPECT_TRUE(meets_flat({Vec3d{1, 1, -1}, {1, 1, 1}, {9, 9, 1}}));
  EXPECT_TRUE(meets_flat({Vec3d{-9, 1, -1}, {9, 1, -1}, {1, 1, 9}}));
  EXPECT_FALSE(meets_flat({Vec3d{3, 3, -1}, {3, 3, 1}, {9, 9, 1}}));
  EXPECT_FALSE(meets_flat({Vec3d{1, 1, 0x1p-1074}, {1, 1, 1}, {9, 9, 1}}));
}

TEST(ExactTriangles, TouchingAtAPoint) {
  EXPECT_TRUE(meets_flat({Vec3d{1, 1, 0}, {1, 1, 1}, {9, 9, 1}}));     // a corner on the inside
  EXPECT_TRUE(meets_flat({Vec3d{4, 0, 0}, {5, 0, 1}, {5, 0, -1}}));    // corner to corner
  EXPECT_TRUE(meets_flat({Vec3d{2, 2, 0}, {5, 5, 1}, {5, 5, -1}}));    // a corner on a side
  EXPECT_TRUE(meets_flat({Vec3d{2, -1, -1}, {2, 1, 1}, {2, -9, 9}}));  // side to side
  EXPECT_FALSE(meets_flat({Vec3d{2, 2 + 0x1p-51, 0}, {5, 5, 1}, {5, 5, -1}}));
}

TEST(ExactTriangles, Coplanar) {
  EXPECT_TRUE(meets_flat(kFlat));
  EXPECT_TRUE(meets_flat({Vec3d{1, 1, 0}, {1.5, 1, 0}, {1, 1.5, 0}}));    // within
  EXPECT_TRUE(meets_flat({Vec3d{-9, -9, 0}, {99, -9, 0}, {-9, 99, 0}}));  // around
  EXPECT_TRUE(meets_flat({Vec3d{-1, 1, 0}, {9, 1, 0}, {9, 2, 0}}));       // sides cross, no corner within
  EXPECT_TRUE(meets_flat({Vec3d{4, 0, 0}, {8, 0, 0}, {8, 4, 0}}));        // at a corner
  EXPECT_TRUE(meets_flat({Vec3d{3, 1, 0}, {1, 3, 0}, {9, 9, 0}}));        // along a side
  EXPECT_FALSE(meets_flat({Vec3d{3, 1 + 0x1p-51, 0}, {1 + 0x1p-51, 3, 0}, {9, 9, 0}}));
  EXPECT_FALSE(meets_flat({Vec3d{1, 1, 1}, {1.5, 1, 1}, {1, 1.5, 1}}));  // parallel planes
}

TEST(ExactTriangles, SegmentsAndPoints) {
  EXPECT_TRUE(meets_flat({Vec3d{1, 1, -1}, {1, 1, 1}, {1, 1, 0.5}}));
  EXPECT_TRUE(meets_flat({Vec3d{1, 1, -1}, {1, 1, 1}, {1, 1, 1}}));
  EXPECT_FALSE(meets_flat({Vec3d{3, 3, -1}, {3, 3, 1}, {3, 3, 1}}));
  EXPECT_TRUE(meets_flat({Vec3d{2, 2, 0}, {2, 2, 0}, {2, 2, 0}}));
  EXPECT_FALSE(meets_flat({Vec3d{2, 2 + 0x1p-51, 0}, {2, 2 + 0x1p-51, 0}, {2, 2 + 0x1p-51, 0}}));
  const Vec3d p{7, 8, 9}, q{8, 8, 9};
  EXPECT_TRUE(judge_triangles({p, p, p}, {p, p, p}));
  EXPECT_FALSE(judge_triangles({p, p, p}, {q, q, q}));
  EXPECT_TRUE(judge_triangles({p, q, q}, {Vec3d{7.5, 7, 9}, {7.5, 9, 9}, {7.5, 9, 9}}));
}

// --- The other way --------------------------------------------------------------------------------------------------

using Int3 = std::array<int64_t, 3>;

Int3 minus(const Int3& a, const Int3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
int64_t dot(const Int3& a, const Int3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Int3 cross(const Int3& a, const Int3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
int64_t determinant(const Int3& a, const Int3& b, const Int3& c) { return dot(a, cross(b, c)); }

// All of one sign, and their sum is not 0.
bool are_weights(std::initializer_list<int64_t> values) {
  int64_t sum = 0;
  bool negative = false, positive = false;
  for (const int64_t v : values) {
    sum += v;
    negative = negative || v < 0;
    positive = positive || v > 0;
  }
  return sum != 0 && negative != positive;
}

bool hull_has_zero(const Int3& a, const Int3& b) { return cross(a, b) == Int3{} && dot(a, b) <= 0; }
bool hull_has_zero(const Int3& a, const Int3& b, const Int3& c) {
  const Int3 n = cross(minus(b, a), minus(c, a));
  return determinant(a, b, c) == 0 && are_weights({dot(cross(b, c), n), dot(cross(c, a), n), dot(cross(a, b), n)});
}
bool hull_has_zero(const Int3& a, const Int3& b, const Int3& c, const Int3& d) {
  return are_weights({determinant(b, c, d), -determinant(a, c, d), determinant(a, b, d), -determinant(a, b, c)});
}

bool hull_has_zero(const std::vector<Int3>& p) {
  for (size_t i = 0; i < p.size(); ++i)
    for (size_t j = i; j < p.size(); ++j) {
      if (hull_has_zero(p[i], p[j])) return true;
      for (size_t k = j + 1; k < p.size(); ++k) {
        if (hull_has_zero(p[i], p[j], p[k])) return true;
        for (size_t l = k + 1; l < p.size(); ++l)
          if (hull_has_zero(p[i], p[j], p[k], p[l])) return true;
      }
    }
  return false;
}

bool hulls_meet(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  const auto integers = [](const Vec3d& p) { return Int3{int64_t(p[0]), int64_t(p[1]), int64_t(p[2])}; };
  std::vector<Int3> differences;
  for (const Vec3d& p : a)
    for (const Vec3d& q : b) differences.push_back(minus(integers(p), integers(q)));
  return hull_has_zero(differences);
}

// Points of a lattice so small that nearly every degeneracy occurs.
class Lattice {
 public:
  Vec3d operator()(int size) {
    std::uniform_int_distribution<int> coordinate(-size, size);
    return {double(coordinate(random_)), double(coordinate(random_)), double(coordinate(random_))};
  }

 private:
  std::mt19937 random_{5};
};

TEST(ExactTriangles, AgreesWithTheOtherWayOnALattice) {
  Lattice point;
  size_t meeting = 0;
  for (int n = 0; n < 12000; ++n) {
    const int size = 1 + n % 4;
    const Triangle a{point(size), point(size), point(size)}, b{point(size), point(size), point(size)};
    const bool expected = hulls_meet({a[0], a[1], a[2]}, {b[0], b[1], b[2]});
    ASSERT_EQ(judge_triangles(a, b), expected) << n;
    meeting += expected;
  }
  std::printf("12,000 pairs of triangles: 0 disagree, %zu meet\n", meeting);
}

bool has_area(const Triangle& t) {
  const auto at = [&](size_t i) { return Int3{int64_t(t[i][0]), int64_t(t[i][1]), int64_t(t[i][2])}; };
  return cross(minus(at(1), at(0)), minus(at(2), at(0))) != Int3{};
}

// Triangles with area are in one half of space each, seen from their corner: they have a second point in common if and
// only if there is a direction in which both go.
bool share_a_direction(const Triangle& a, const Triangle& b) {
  const auto to = [](const Vec3d& from, const Vec3d& p, int64_t sign) {
    return Int3{sign * int64_t(p[0] - from[0]), sign * int64_t(p[1] - from[1]), sign * int64_t(p[2] - from[2])};
  };
  return hull_has_zero({to(a[0], a[1], 1), to(a[0], a[2], 1), to(a[0], b[1], -1), to(a[0], b[2], -1)});
}

TEST(ExactTriangles, NeighboursAgreeWithTheOtherWayOnALattice) {
  Lattice point;
  size_t meeting = 0, flat = 0;
  for (int n = 0; n < 12000; ++n) {
    const int size = 1 + n % 4;
    const Triangle a{point(size), point(size), point(size)}, b{a[0], point(size), point(size)};
    const bool have_area = has_area(a) && has_area(b);
    const bool expected =
        have_area ? share_a_direction(a, b)
                  : hulls_meet({a[1], a[2]}, {b[0], b[1], b[2]}) || hulls_meet({b[1], b[2]}, {a[0], a[1], a[2]});
    ASSERT_EQ(judge_neighbours(a, b), expected) << n;
    ASSERT_EQ(judge_neighbours({b[0], b[2], b[1]}, a), expected) << n;
    meeting += expected, flat += !have_area;
  }
  EXPECT_GT(meeting, 2000u);
  EXPECT_GT(flat, 500u);
  std::printf("12,000 pairs of neighbours: 0 disagree, %zu meet, %zu with a triangle without area\n", meeting, flat);
}

TEST(ExactProximity, AgreesWithTheOtherWayOnALattice) {
  Lattice point;
  for (int n = 0; n < 20000; ++n) {
    const int size = 1 + n % 3;
    const std::array<Vec3d, 4> p{point(size), point(size), point(size), point(size)};
    ASSERT_EQ(judge_proximity(QueryKind::kVertexTriangle, p, 0), hulls_meet({p[0]}, {p[1], p[2], p[3]})) << n;
    ASSERT_EQ(judge_proximity(QueryKind::kEdgeEdge, p, 0), hulls_meet({p[0], p[1]}, {p[2], p[3]})) << n;
  }
}

}  // namespace
}  // namespace collided::test
