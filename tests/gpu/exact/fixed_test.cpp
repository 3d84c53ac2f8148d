// Integers of fixed size against GMP, and the decisions made in them against those in integers of any size.

#include <gtest/gtest.h>

#include <gmpxx.h>

#include <cmath>
#include <map>
#include <random>

#include "gpu/exact/features.hpp"
#include "gpu/exact/fixed/decide.hpp"
#include "gpu/exact/roots/root.hpp"
#include "tests/gpu/exact/queries.hpp"

namespace collided::test {
namespace {

using exact::Form;
using exact::fixed::Cubic;
using exact::fixed::Integer;
using exact::fixed::Look;
using exact::fixed::Outcome;
using exact::fixed::Unit;
using exact::fixed::Verdict;

template <int N>
mpz_class value(const Integer<N>& a) {
  mpz_class n;
  mpz_import(n.get_mpz_t(), N, -1, sizeof(uint64_t), 0, 0, a.limb);
  return a.is_negative() ? mpz_class(n - (mpz_class(1) << (64 * N))) : n;
}

/// Limbs of zeros and ones, where carries go far, and others.
template <int N>
Integer<N> any_integer(std::mt19937_64& random) {
  Integer<N> a;
  for (uint64_t& limb : a.limb) {
    const uint64_t choice = random() % 4;
    limb = choice == 0 ? 0 : choice == 1 ? ~uint64_t{0} : random();
  }
  return a;
}

template <int N, int M>
void expect_arithmetic() {
  std::mt19937_64 random(N * 10 + M);
  for (int i = 0; i < 2000; ++i) {
    const Integer<N> a = any_integer<N>(random), same_width = any_integer<N>(random);
    const Integer<M> b = any_integer<M>(random);
    const mpz_class x = value(a), y = value(b), z = value(same_width), wrap = mpz_class(1) << (64 * N);
    ASSERT_EQ(value(a * b), x * y);
    ASSERT_EQ((value(a + same_width) - x - z) % wrap, 0);
    ASSERT_EQ((value(a - same_width) - x + z) % wrap, 0);
    ASSERT_EQ(value(exact::fixed::resized<N + 2>(a)), x);
    ASSERT_EQ(a.sign(), sgn(x));
    ASSERT_EQ(a.is_zero(), x == 0);
    const mpq_class found(to_double(a)), error = abs(found - x);
    ASSERT_LE(error * (mpz_class(1) << 51), abs(x));
  }
}

TEST(FixedIntegers, AreThoseOfGmp) {
  expect_arithmetic<1, 1>();
  expect_arithmetic<2, 1>();
  expect_arithmetic<1, 2>();
  expect_arithmetic<3, 3>();
  expect_arithmetic<6, 3>();
  expect_arithmetic<8, 1>();
}

TEST(FixedUnit, CountsWhatFits) {
  Unit unit;
  for (const double x : {3.0, -0x1p-30, 0.0, 0x1p29}) unit.see(x);
  EXPECT_TRUE(unit.fits<1>());
  EXPECT_EQ(value(unit.count<1>(3)), mpz_class(3) << 30);
  EXPECT_EQ(value(unit.count<1>(-0x1p-30)), -1);
  EXPECT_EQ(value(unit.count<2>(0x1p29)), mpz_class(1) << 59);
  EXPECT_EQ(value(unit.count<1>(0)), 0);
  unit.see(0x1p30);
  EXPECT_FALSE(unit.fits<1>());
  EXPECT_TRUE(unit.fits<2>());
  EXPECT_EQ(value(unit.count<2>(-0x1p30)), -(mpz_class(1) << 60));
  unit.see(0x1p93);
  EXPECT_TRUE(unit.fits<2>());
  unit.see(0x1p94);
  EXPECT_FALSE(unit.fits<2>());
}

TEST(FixedUnit, CountsTheSmallestAndTheLargestNumbers) {
  Unit tiny, huge;
  for (const double x : {kTiniest, 3 * kTiniest, 0x1p-1022}) tiny.see(x);
  EXPECT_EQ(value(tiny.count<1>(3 * kTiniest)), 3);
  EXPECT_EQ(value(tiny.count<1>(0x1p-1022)), mpz_class(1) << 52);
  const double largest = std::numeric_limits<double>::max();
  huge.see(largest);
  EXPECT_EQ(value(huge.count<1>(-largest)), -((mpz_class(1) << 53) - 1));
}

/// With small coefficients, some of them 0, or with given roots, some of them double.
Cubic<3> any_cubic(std::mt19937& random) {
  std::uniform_int_distribution<int> integer(-6, 6), one_in_two(0, 1);
  Cubic<3> f;
  if (one_in_two(random) == 0) {
    for (Integer<3>& c : f.c) c = Integer<3>::of(integer(random));
    return f;
  }
  int64_t c[4] = {1, 0, 0, 0};
  for (int factor = 1; factor <= 3; ++factor) {  // a s + b t
    const int64_t a = integer(random), b = integer(random);
    for (int i = 3; i > 0; --i) c[i] = a * c[i] + b * c[i - 1];
    c[0] *= a;
  }
  for (int i = 0; i < 4; ++i) f.c[i] = Integer<3>::of(c[i]);
  return f;
}

TEST(FixedRoots, AreThoseInIntegersOfAnySize) {
  std::mt19937 random(5);
  int counts[4] = {}, left_open = 0;
  for (int i = 0; i < 4000; ++i) {
    const Cubic<3> f = any_cubic(random);
    Form form;
    form.c.clear();
    for (const Integer<3>& c : f.c) form.c.push_back(exact::Number::of(value(c).get_mpz_t()));
    if (form.vanishes()) continue;
    std::vector<double> expected, found;
    for (exact::Root& root : exact::roots_inside(form)) expected.push_back(root.rounded_down());
    const Look look = for_each_root(f, [&](uint64_t k, bool) {
      found.push_back(exact::fixed::time_of(k));
      return Look::kGoOn;
    });
    if (look == Look::kOpen) {
      ++left_open;
      continue;
    }
    ASSERT_EQ(found, expected) << value(f.c[0]) << ' ' << value(f.c[1]) << ' ' << value(f.c[2]) << ' ' << value(f.c[3]);
    ++counts[found.size()];
  }
  for (const int count : counts) EXPECT_GT(count, 20);
  EXPECT_GT(left_open, 20) << "double roots";
  EXPECT_LT(left_open, 1000);
}

TEST(FixedRoots, ATimeIsRoundedDown) {
  using exact::fixed::kOne;
  for (const uint64_t k : {uint64_t{0}, uint64_t{1}, kOne - 1, kOne / 3, (uint64_t{1} << 53) + 1}) {
    const double time = exact::fixed::time_of(k);
    const mpq_class truth(mpz_class(static_cast<unsigned long>(k)), mpz_class(1) << 60);
    EXPECT_LE(mpq_class(time), truth);
    EXPECT_GT(mpq_class(std::nextafter(time, 2)), truth);
  }
}

constexpr ContactKind kKinds[] = {ContactKind::kVertexTriangle, ContactKind::kEdgeEdge};

Verdict decide(ContactKind kind, const Query& q) { return exact::fixed::decide(kind, q.start, q.end); }

/// In integers of any size alone.
ExactImpact in_any_size(ContactKind kind, const Query& q) {
  return exact::first_impact(exact::contact_in_any_size(kind, q.start, q.end, 0));
}

void expect_same(const Verdict& found, const ExactImpact& expected) {
  EXPECT_EQ(found.outcome != Outcome::kApart, expected.hit);
  EXPECT_EQ(found.outcome == Outcome::kAtStart, expected.initial);
  EXPECT_EQ(found.toi, expected.toi);
}

/// Small integers: some points at rest, some with a point's or a direction's coordinates in common.
Query any_query(std::mt19937& random) {
  std::uniform_int_distribution<int> integer(-3, 3), one_in_four(0, 3);
  const bool is_flat = one_in_four(random) == 0;
  const auto point = [&] {
    const double x = integer(random), y = integer(random), z = integer(random);
    return Point{x, y, is_flat ? 0 : z};
  };
  Query q;
  for (int i = 0; i < 4; ++i) {
    q.start[i] = point();
    q.end[i] = one_in_four(random) == 0 ? q.start[i] : point();
  }
  if (one_in_four(random) == 0) q.start[3] = q.start[2], q.end[3] = q.end[2];
  return q;
}

/// Which changes no answer.
Query stretched(const Query& q, int exponent) {
  return changed(q, [&](const Point& p, bool) { return Point{p.x, std::ldexp(p.y, exponent), p.z}; });
}

class FixedDecisions : public ::testing::TestWithParam<int> {};

// The parameter stretches the queries, so that they need numbers of so many bits more: one limb, or two.
TEST_P(FixedDecisions, AreThoseInIntegersOfAnySize) {
  std::mt19937 random(11);
  std::map<Outcome, int> counts;
  for (int i = 0; i < 800; ++i) {
    const Query q = any_query(random);
    for (const ContactKind kind : kKinds) {
      const Verdict found = decide(kind, stretched(q, GetParam()));
      ++counts[found.outcome];
      if (found.outcome != Outcome::kOpen) expect_same(found, in_any_size(kind, q));
    }
    ASSERT_FALSE(HasFailure()) << "query " << i;
  }
  for (const Outcome outcome : {Outcome::kOpen, Outcome::kApart, Outcome::kAtStart, Outcome::kBetween, Outcome::kAtEnd})
    EXPECT_GT(counts[outcome], 10) << static_cast<int>(outcome);
  EXPECT_LT(counts[Outcome::kOpen], 1100) << "of 1600";
}

INSTANTIATE_TEST_SUITE_P(Bits, FixedDecisions, ::testing::Values(0, 30, 58, 59, 90, 122));

TEST(FixedDecision, KnownOutcomes) {
  const auto outcome = [](const Point& from, const Point& to) {
    return decide(ContactKind::kVertexTriangle, vertex_at_corner_triangle(from, to)).outcome;
  };
  EXPECT_EQ(outcome({1, 1, 0}, {1, 1, 5}), Outcome::kAtStart);
  EXPECT_EQ(outcome({1, 1, 5}, {1, 1, 0}), Outcome::kAtEnd);
  EXPECT_EQ(outcome({1, 1, 1}, {1, 1, -2}), Outcome::kBetween);
  EXPECT_EQ(outcome({1, 1, 1}, {1, 1, 2}), Outcome::kApart);
  EXPECT_EQ(outcome({5, 5, 1}, {5, 5, -2}), Outcome::kApart);
  EXPECT_EQ(outcome({1, 0, 1}, {1, 0, -2}), Outcome::kBetween) << "on a side";
  EXPECT_EQ(outcome({0, 0, 1}, {0, 0, -2}), Outcome::kBetween) << "on a corner";
  EXPECT_EQ(outcome({2, 2, 1}, {2, 2, -2}), Outcome::kBetween) << "on the slanting side";
  EXPECT_EQ(outcome({-1, 1, 0}, {2, 1, 0}), Outcome::kBetween) << "in the plane";
  EXPECT_EQ(outcome({-1, 1, 0}, {-2, 1, 0}), Outcome::kApart) << "in the plane";
  EXPECT_EQ(outcome({1, 1, 1}, {1, 1, -0x1p-70}), Outcome::kBetween) << "in two limbs";
  EXPECT_EQ(outcome({1, 1, 1}, {1, 1, -0x1p-200}), Outcome::kOpen) << "in neither";
}

// Beside a side by one unit of the last place: to either side, where double precision sees the side itself.
TEST(FixedDecision, WithinRoundingErrorsOfASide) {
  for (const double gap : {0x1p-52, 0x1p-58, 0x1p-100}) {
    for (const double x : {-gap, 0.0, gap}) {
      const Query q = vertex_at_corner_triangle({x, 1, 1}, {x, 1, -2});
      const Verdict found = decide(ContactKind::kVertexTriangle, q);
      if (found.outcome != Outcome::kOpen) expect_same(found, in_any_size(ContactKind::kVertexTriangle, q));
      EXPECT_EQ(vertex_triangle(q).hit, x >= 0);
    }
  }
}

// All points are in a plane that turns about x, and is upright at t = 1/2; the vertex stays beside the triangle.
TEST(FixedDecision, APlaneThatTurnsIsLeftOpen) {
  const Point flat[4] = {{1, 5, 0}, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  Query q;
  for (int i = 0; i < 4; ++i) q.start[i] = flat[i], q.end[i] = {flat[i].x, -flat[i].y, flat[i].y};
  EXPECT_EQ(decide(ContactKind::kVertexTriangle, q).outcome, Outcome::kOpen);
  expect_same({Outcome::kApart, 1}, vertex_triangle(q));
}

TEST(FixedDecision, AtRest) {
  const auto outcome = [](const Point& v) {
    return exact::fixed::decide_at_rest(ContactKind::kVertexTriangle, {v, kOrigin, {4, 0, 0}, {0, 4, 0}});
  };
  EXPECT_EQ(outcome({1, 1, 0}), Outcome::kAtStart);
  EXPECT_EQ(outcome({0, 4, 0}), Outcome::kAtStart);
  EXPECT_EQ(outcome({-0x1p-50, 4, 0}), Outcome::kApart);
  EXPECT_EQ(outcome({1, 1, 0x1p-100}), Outcome::kApart);
  EXPECT_EQ(outcome({1, 1, kTiniest}), Outcome::kOpen);
}

TEST(FixedDecision, AtRestWithoutArea) {
  const Point a{0, 0, 0}, b{4, 0, 0};
  const auto touches = [](ContactKind kind, const Point(&p)[4]) {
    return exact::fixed::decide_at_rest(kind, p) == Outcome::kAtStart;
  };
  for (const double x : {0.0, 2.0, 4.0}) {
    EXPECT_TRUE(touches(ContactKind::kVertexTriangle, {{x, 0, 0}, a, b, b})) << x;
    EXPECT_TRUE(touches(ContactKind::kEdgeEdge, {{x, 0, 0}, {x + 7, 0, 0}, a, b})) << x;
    EXPECT_TRUE(touches(ContactKind::kEdgeEdge, {a, b, {x, 0, 0}, {x, 0, 0}})) << x;
  }
  for (const double x : {-0x1p-40, 4 + 0x1p-40})
    EXPECT_FALSE(touches(ContactKind::kVertexTriangle, {{x, 0, 0}, a, b, b}));
  EXPECT_FALSE(touches(ContactKind::kEdgeEdge, {a, b, {5, 0, 0}, {7, 0, 0}}));
  EXPECT_FALSE(touches(ContactKind::kEdgeEdge, {a, b, {0, 1, 0}, {4, 1, 0}}));
}

}  // namespace
}  // namespace collided::test
