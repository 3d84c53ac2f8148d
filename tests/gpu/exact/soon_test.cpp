// Numbers of twice double's precision against rationals, and what they say of features that meet soon against integers
// of any size.

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "gpu/exact/features.hpp"
#include "gpu/exact/fixed/decide.hpp"
#include "tests/gpu/exact/queries.hpp"

namespace collided::test {
namespace {

using exact::fixed::Outcome;
using exact::fixed::Verdict;

mpq_class value(const Twofold& a) { return mpq_class(a.high) + mpq_class(a.low); }

double any_number(std::mt19937_64& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  std::uniform_int_distribution<int> exponent(-40, 40);
  return std::ldexp(number(random), exponent(random));
}
Twofold any_twofold(std::mt19937_64& random) { return exact_sum(any_number(random), any_number(random) * 0x1p-60); }

TEST(Twofold, SumsAndProductsOfDoublesAreExact) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const double a = any_number(random), b = any_number(random);
    ASSERT_EQ(value(exact_sum(a, b)), mpq_class(a) + mpq_class(b));
    ASSERT_EQ(value(exact_product(a, b)), mpq_class(a) * mpq_class(b));
    ASSERT_EQ(exact_product(a, b).low, std::fma(a, b, -(a * b))) << "as on a GPU";
  }
}

TEST(Twofold, ErrorsAreWithinTheirBounds) {
  std::mt19937_64 random(2);
  const mpq_class u2 = mpq_class(0x1p-106);
  for (int i = 0; i < 20000; ++i) {
    const Twofold a = any_twofold(random), b = any_twofold(random);
    const mpq_class x = value(a), y = value(b), size = abs(x) + abs(y), product = abs(x * y);
    ASSERT_LE(abs(value(a + b) - x - y), 3 * u2 * size);
    ASSERT_LE(abs(value(a - b) - x + y), 3 * u2 * size);
    ASSERT_LE(abs(value(a * b) - x * y), 8 * u2 * product);
  }
}

constexpr ContactKind kKinds[] = {ContactKind::kVertexTriangle, ContactKind::kEdgeEdge};

Verdict decide_soon(ContactKind kind, const Query& q, double from) {
  return kind == ContactKind::kVertexTriangle
             ? exact::fixed::decide_soon<ContactKind::kVertexTriangle>(q.start, q.end, from)
             : exact::fixed::decide_soon<ContactKind::kEdgeEdge>(q.start, q.end, from);
}
Verdict decide_from(ContactKind kind, const Query& q, double from) {
  return kind == ContactKind::kVertexTriangle
             ? exact::fixed::decide_from<ContactKind::kVertexTriangle>(q.start, q.end, from)
             : exact::fixed::decide_from<ContactKind::kEdgeEdge>(q.start, q.end, from);
}
ExactImpact in_any_size(ContactKind kind, const Query& q) {
  return exact::first_impact(exact::contact_in_any_size(kind, q.start, q.end, 0));
}

/// Points in a cube of side 2 about `centre`, on a lattice of 2^-bits.
Query any_query(std::mt19937_64& random, double centre, int bits) {
  std::uniform_real_distribution<double> number(-1, 1);
  const auto coordinate = [&] { return centre + std::ldexp(std::round(std::ldexp(number(random), bits)), -bits); };
  Query q;
  for (int i = 0; i < 4; ++i) {
    q.start[i] = {coordinate(), coordinate(), coordinate()};
    q.end[i] = {coordinate(), coordinate(), coordinate()};
  }
  return q;
}

/// Centre and bits of the lattice: coarse ones have roots at simple fractions, and conditions that are just met.
struct Place {
  double centre;
  int bits;
};
class SoonMeetings : public ::testing::TestWithParam<Place> {};

TEST_P(SoonMeetings, AreThoseInIntegersOfAnySize) {
  std::mt19937_64 random(3);
  std::uniform_int_distribution<int> exponent(-60, -1);
  int meetings = 0, decided = 0;
  for (int i = 0; i < 12000; ++i) {
    const Query q = any_query(random, GetParam().centre, GetParam().bits);
    const ContactKind kind = kKinds[i % 2];
    const ExactImpact truth = in_any_size(kind, q);
    // A time before the first contact, or the whole step.
    const double from = truth.hit ? std::max(0.0, truth.toi - std::ldexp(1.0, exponent(random))) : 0;
    const Verdict found = decide_soon(kind, q, from), whole = decide_from(kind, q, from);
    if (whole.outcome != Outcome::kOpen) {
      ASSERT_EQ(whole.outcome != Outcome::kApart, truth.hit) << i;
      ASSERT_EQ(whole.outcome == Outcome::kAtStart, truth.initial) << i;
      ASSERT_EQ(whole.toi, truth.toi) << i;
    }
    meetings += truth.hit && !truth.initial && truth.toi < 1;
    if (found.outcome == Outcome::kOpen) continue;
    ++decided;
    ASSERT_NE(whole.outcome, Outcome::kOpen) << i;
    ASSERT_EQ(found.outcome, Outcome::kBetween) << i;
    ASSERT_TRUE(truth.hit && !truth.initial) << i;
    ASSERT_EQ(found.toi, truth.toi) << i;
  }
  EXPECT_GT(meetings, 500);
  EXPECT_GT(decided, meetings / 5) << "of " << meetings;
}

INSTANTIATE_TEST_SUITE_P(Places, SoonMeetings,
                         ::testing::Values(Place{0, 2}, Place{0, 20}, Place{0, 50}, Place{1e5, 30}, Place{-3e15, 0}));

// Contacts that are there at 0, that only just come, or leave at once.
TEST(SoonMeeting, LeavesOpenWhatIsNotSimple) {
  const auto outcome = [](const Point& from, const Point& to, double time) {
    return decide_soon(ContactKind::kVertexTriangle, vertex_at_corner_triangle(from, to), time).outcome;
  };
  EXPECT_EQ(outcome({1, 1, 1}, {1, 1, -2}, 0), Outcome::kOpen) << "not soon";
  EXPECT_EQ(outcome({1, 1, 1}, {1, 1, -2}, 0.33), Outcome::kBetween);
  EXPECT_EQ(outcome({1, 1, 0}, {1, 1, -2}, 0), Outcome::kOpen) << "in contact at 0";
  EXPECT_EQ(outcome({1, 1, 1}, {1, 1, 0}, 0.9), Outcome::kOpen) << "in contact at 1";
  EXPECT_EQ(outcome({1, 1, 1}, {1, 1, -1}, 0.5), Outcome::kOpen) << "just then";
  EXPECT_EQ(outcome({1, 1, 1}, {1, 1, 2}, 0), Outcome::kOpen) << "apart";
  EXPECT_EQ(outcome({5, 5, 1}, {5, 5, -2}, 0), Outcome::kOpen) << "beside the triangle";
  EXPECT_EQ(outcome({1, 0, 1}, {1, 0, -2}, 0.33), Outcome::kOpen) << "on a side";
  EXPECT_EQ(outcome({0, 0, 1}, {0, 0, -2}, 0.33), Outcome::kOpen) << "on a corner";
  EXPECT_EQ(outcome({-1, 1, 0}, {2, 1, 0}, 0), Outcome::kOpen) << "in the plane";
}

// The vertex passes the plane, comes back into it above the triangle, and passes again.
TEST(SoonMeeting, ARootThatIsNoContactIsNotTakenForOne) {
  Query q = vertex_at_corner_triangle({-0.5, 1, 1}, {1, 1, -1});
  EXPECT_EQ(decide_soon(ContactKind::kVertexTriangle, q, 0).outcome, Outcome::kOpen) << "beside the triangle";
  q.start[0].x = 1;
  EXPECT_EQ(decide_soon(ContactKind::kVertexTriangle, q, 0.25).outcome, Outcome::kOpen)
      << "at 1/2, a multiple of 2^-60";
  q.end[0].z = -1.25;
  EXPECT_EQ(decide_soon(ContactKind::kVertexTriangle, q, 0.4375).toi, in_any_size(ContactKind::kVertexTriangle, q).toi);
}

TEST(SoonMeeting, OfAnySize) {
  const Query q = vertex_at_corner_triangle({1, 1, 1}, {1.25, 1, -2});
  const double toi = decide_soon(ContactKind::kVertexTriangle, q, 0.33).toi;
  ASSERT_NE(toi, 1);
  for (const int exponent : {-900, -280, -30, 0, 30, 280})
    EXPECT_EQ(decide_soon(ContactKind::kVertexTriangle, scaled(q, exponent), 0.33).toi, exponent < -300 ? 1 : toi)
        << exponent;
  for (const int exponent : {-1070, 310, 1000, 1021})
    EXPECT_EQ(decide_soon(ContactKind::kVertexTriangle, scaled(q, exponent), 0.33).outcome, Outcome::kOpen) << exponent;
}

TEST(SoonMeeting, OnASideIsDecidedAtTheRoot) {
  for (const Point& at : {Point{1, 0, 1}, Point{0, 0, 1}, Point{2, 2, 1}}) {
    const Query q = vertex_at_corner_triangle(at, {at.x, at.y, -2});
    EXPECT_EQ(decide_from(ContactKind::kVertexTriangle, q, 0.33).toi, in_any_size(ContactKind::kVertexTriangle, q).toi);
  }
  const Query past = vertex_at_corner_triangle({1, -0x1p-52, 1}, {1, -0x1p-52, -2});
  EXPECT_NE(decide_from(ContactKind::kVertexTriangle, past, 0.33).outcome, Outcome::kBetween);
}

}  // namespace
}  // namespace collided::test
