// Tests on which features closest points are, in integers and in double precision, against a judge that has no
// conditions of optimality.

#include "gpu/exact/closest_features.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>

#include "gpu/narrow/closest_features.hpp"
#include "tests/support/judge/exact_features.hpp"

namespace collided::test {
namespace {

using Point = Vec3<double>;

/// A stencil and its ids.
struct Stencil {
  ContactKind kind = ContactKind::kVertexTriangle;
  Point p[4];
  uint32_t id[4] = {0, 1, 2, 3};
};

std::string text(const Stencil& c) {
  std::string s = c.kind == ContactKind::kVertexTriangle ? "vertex, triangle\n" : "edge, edge\n";
  char line[160];
  for (int i = 0; i < 4; ++i) {
    std::snprintf(line, sizeof line, "%u: %a %a %a\n", c.id[i], c.p[i].x, c.p[i].y, c.p[i].z);
    s += line;
  }
  return s;
}

QueryKind query_kind(ContactKind kind) {
  return kind == ContactKind::kVertexTriangle ? QueryKind::kVertexTriangle : QueryKind::kEdgeEdge;
}
JudgedFeatures truth_of(const Stencil& c) {
  const auto exact = [](const Point& p) { return exact_point({p.x, p.y, p.z}); };
  return judge_features(query_kind(c.kind), {exact(c.p[0]), exact(c.p[1]), exact(c.p[2]), exact(c.p[3])},
                        {c.id[0], c.id[1], c.id[2], c.id[3]});
}

FoundFeatures in_doubles(const Stencil& c) {
  return c.kind == ContactKind::kVertexTriangle ? closest_features<VertexTriangle>(c.p, c.id)
                                                : closest_features<EdgeEdge>(c.p, c.id);
}

/// What a test went through.
struct Count {
  int of[16] = {}, ties = 0, equal = 0, certain = 0, wrong_in_doubles = 0;
};

/// Expects the truth, and says if double precision was certain of it.
void expect_truth(const Stencil& c, Count& count) {
  const JudgedFeatures truth = truth_of(c);
  ASSERT_EQ(exact_closest_features(c.kind, c.p, c.id), truth.features) << text(c);
  const FoundFeatures found = in_doubles(c);
  ASSERT_TRUE(!found.is_certain || found.features == truth.features) << text(c);
  ++count.of[truth.features];
  count.ties += truth.ties > 1, count.equal += truth.is_equal;
  count.certain += found.is_certain, count.wrong_in_doubles += found.features != truth.features;
}

/// Makes random cases of one kind.
class AnyCases {
 public:
  explicit AnyCases(ContactKind kind) : kind_(kind) {}

  Stencil any() {
    Stencil c{kind_, {}};
    std::shuffle(std::begin(c.id), std::end(c.id), random_);
    return c;
  }
  /// Points of a lattice with `size` coordinates an axis.
  Stencil of_lattice(int size) {
    Stencil c = any();
    for (Point& p : c.p)
      for (double* x : {&p.x, &p.y, &p.z}) *x = integer(0, size - 1);
    return c;
  }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  double number() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  Point point() { return {number(), number(), number()}; }

 private:
  ContactKind kind_;
  std::mt19937_64 random_{1};
};

class ClosestFeatures : public testing::TestWithParam<ContactKind> {
 protected:
  bool is_triangle() const { return GetParam() == ContactKind::kVertexTriangle; }
  /// Every feature was the answer.
  void expect_all(const Count& count, int least) const {
    for (const FeaturePair& pair : feature_pairs(query_kind(GetParam())))
      EXPECT_GE(count.of[pair.features], least) << int{pair.features};
  }

  AnyCases cases_{GetParam()};
};
INSTANTIATE_TEST_SUITE_P(Kinds, ClosestFeatures, testing::Values(ContactKind::kVertexTriangle, ContactKind::kEdgeEdge),
                         [](const auto& kind) { return kind.param == ContactKind::kEdgeEdge ? "Edges" : "Triangle"; });

TEST_P(ClosestFeatures, FullOfTies) {
  Count count;
  const int n = 12000;
  for (int i = 0; i < n; ++i) {
    Stencil c = cases_.of_lattice(2 + i % 5);
    const double unit = std::ldexp(1.0, cases_.integer(-300, 300));
    const Point offset = i % 2 == 0 ? Point{0, 0, 0} : Point{0x1p50, -0x1p47, 3};
    for (Point& p : c.p) p = unit * (p + offset);
    expect_truth(c, count);
    if (HasFatalFailure()) return;
  }
  expect_all(count, 20);
  EXPECT_GT(count.ties, 4000);
  EXPECT_GT(count.equal, 400);
  EXPECT_EQ(count.certain, n) << "small integers leave no doubt";
}

/// In one plane, or on one line.
TEST_P(ClosestFeatures, Flat) {
  Count count;
  const int n = 8000;
  for (int i = 0; i < n; ++i) {
    Stencil c = cases_.of_lattice(5);
    const int slope = cases_.integer(0, 2);
    for (Point& p : c.p) {
      if (i % 3 == 0) p.y = p.x;
      p.z = p.x + slope * p.y;
      if (i % 2 == 0) std::swap(p.x, p.z);
    }
    expect_truth(c, count);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(count.equal, 300);
  EXPECT_EQ(count.certain, n);
}

/// Parallel edges that overlap, are equal or have no length; triangles without area, above a vertex.
TEST_P(ClosestFeatures, WithoutLengthOrArea) {
  Count count;
  const int n = 8000;
  for (int i = 0; i < n; ++i) {
    Stencil c = cases_.of_lattice(3);
    const Point way = c.p[1] - c.p[0];
    const auto along = [&](double at) { return at * way; };
    const double a = cases_.integer(-2, 2), b = cases_.integer(-2, 2);
    if (is_triangle()) {
      c.p[2] = c.p[1] + along(a);
      c.p[3] = c.p[1] + along(b);
      if (i % 2 == 0) c.p[0] = cases_.of_lattice(5).p[0];
    } else {
      c.p[2] = c.p[2] + along(a);
      c.p[3] = c.p[2] + along(b);
      if (i % 4 == 0) c.p[2] = c.p[0];
    }
    expect_truth(c, count);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(count.equal, 800);
  EXPECT_EQ(count.certain, n);
}

/// A loose edge is a triangle a b b, a loose point a a a: equal vertices have equal names.
TEST(ClosestFeaturesOfLooseElements, HaveOneName) {
  AnyCases cases(ContactKind::kVertexTriangle);
  Count count;
  const int n = 6000;
  for (int i = 0; i < n; ++i) {
    Stencil c = cases.of_lattice(4);
    if (i % 2 == 0)
      for (Point& p : c.p) p = cases.point() + Point{1e3, 0, 0};
    c.p[3] = c.p[2], c.id[3] = c.id[2];
    if (i % 5 == 0) c.p[2] = c.p[3] = c.p[1], c.id[2] = c.id[3] = c.id[1];
    expect_truth(c, count);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(count.of[2], 500);
  EXPECT_GT(count.of[4], 1000);
  EXPECT_GT(count.of[5], 200);
  EXPECT_EQ(count.of[2] + count.of[4] + count.of[5], n);
  EXPECT_GT(count.certain, n - 10);
}

/// Doubles in general position; in every third case far from the origin, so that differences have few bits and are
/// still exact; in others with exponents far apart.
TEST_P(ClosestFeatures, OfAnySize) {
  Count ordinary, wide;
  const int n = 12000;
  for (int i = 0; i < n; ++i) {
    Stencil c = cases_.any();
    const double unit = std::ldexp(1.0, cases_.integer(-300, 300));
    const Point offset = i % 3 == 0 ? Point{0x1p30 * cases_.number(), 0x1p30, -0x1p30} : Point{0, 0, 0};
    const bool is_wide = i % 4 == 1;
    for (Point& p : c.p) {
      p = cases_.point() + offset;
      p = (is_wide ? unit * std::ldexp(1.0, cases_.integer(-200, 200)) : unit) * p;
    }
    expect_truth(c, is_wide ? wide : ordinary);
    if (HasFatalFailure()) return;
  }
  expect_all(ordinary, 100);
  EXPECT_GT(ordinary.certain, 3 * n / 4 - 10);
  EXPECT_GT(wide.certain, 1000);
}

/// Almost ties: rounded turns of a lattice. Double precision is not certain of all of them, and not right.
TEST_P(ClosestFeatures, TurnedLattices) {
  Count count;
  const int n = 6000;
  for (int i = 0; i < n; ++i) {
    Stencil c = cases_.of_lattice(3);
    const double angle = cases_.number(), cosine = std::cos(angle), sine = std::sin(angle);
    for (Point& p : c.p) {
      p = {cosine * p.x - sine * p.y, sine * p.x + cosine * p.y, p.z};
      p = {p.x, cosine * p.y - sine * p.z, sine * p.y + cosine * p.z};
      if (i % 2 == 0) p = p + Point{100, 100, 100};
    }
    expect_truth(c, count);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(n - count.certain, 1000);
  EXPECT_GT(count.wrong_in_doubles, 50);
}

/// What differences of a lattice's points leave out decides ties.
TEST_P(ClosestFeatures, RoundedDifferences) {
  Count count;
  const int n = 6000;
  for (int i = 0; i < n; ++i) {
    Stencil c = cases_.of_lattice(3);
    const size_t moved = static_cast<size_t>(i) % 4;
    for (double* x : {&c.p[moved].x, &c.p[moved].y, &c.p[moved].z})
      if (*x == 0) *x = cases_.integer(-1, 1) * 0x1p-60;
    expect_truth(c, count);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(count.wrong_in_doubles, 50);
}

/// The least and the largest numbers; differences that vanish beside others.
TEST_P(ClosestFeatures, ExtremeNumbers) {
  const std::array<double, 9> values = {0, 0x1p-1074, -0x1p-1074, 0x1p-1022, 1e-200, -1, 1 + 0x1p-52, 1e150, -1e300};
  Count count;
  for (int i = 0; i < 1500; ++i) {
    Stencil c = cases_.any();
    for (Point& p : c.p)
      for (double* x : {&p.x, &p.y, &p.z}) *x = values[static_cast<size_t>(cases_.integer(0, 8))];
    if (i % 2 == 0)
      for (Point& p : c.p) p.z = 0, p.y = i % 4 == 0 ? 0 : p.y;
    expect_truth(c, count);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(count.equal, 50);
  EXPECT_GT(count.certain, 20);
}

TEST(ClosestFeaturesOfPlainCases, AreTheseBits) {
  const uint32_t ids[4] = {7, 3, 9, 5};
  const auto of_triangle = [&](const Point& p) {
    return exact_closest_features(ContactKind::kVertexTriangle, {p, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, ids);
  };
  EXPECT_EQ(of_triangle({1, 1, 1}), 0);
  EXPECT_EQ(of_triangle({3, 3, 1}), 1);
  EXPECT_EQ(of_triangle({-1, 1, 1}), 2);
  EXPECT_EQ(of_triangle({1, -1, 1}), 3);
  EXPECT_EQ(of_triangle({-1, 0, 1}), 4) << "above the end of a side";
  EXPECT_EQ(of_triangle({9, 0, 1}), 5);
  EXPECT_EQ(of_triangle({0, 9, 1}), 6);
  const auto of_edges = [&](const Point& b0, const Point& b1) {
    return exact_closest_features(ContactKind::kEdgeEdge, {{0, 0, 0}, {4, 0, 0}, b0, b1}, ids);
  };
  EXPECT_EQ(of_edges({1, -1, 1}, {1, 1, 1}), 0);
  EXPECT_EQ(of_edges({-1, -1, 1}, {-1, 1, 1}), kOfFirstEdge & 1);
  EXPECT_EQ(of_edges({1, 1, 1}, {1, 2, 1}), kOfSecondEdge & 1 << 2);
  EXPECT_EQ(of_edges({5, 1, 1}, {6, 1, 1}), 2 | 1 << 2);
  EXPECT_EQ(of_edges({1, 1, 0}, {2, 1, 0}), 2 << 2) << "parallel: vertex 5 before 9";
  EXPECT_EQ(of_edges({0, 1, 0}, {4, 1, 0}), 2 | 2 << 2) << "equal: vertices 3 and 5 before 7 and 9";
}

}  // namespace
}  // namespace collided::test
