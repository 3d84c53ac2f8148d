// Kinds of queries that have a way of their own, against the plain way: forms of integers of any size, and exact roots.

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

#include "gpu/exact/rough/certain.hpp"
#include "gpu/exact/features.hpp"
#include "gpu/exact/fixed/decide.hpp"
#include "gpu/exact/roots/located.hpp"
#include "gpu/exact/windows.hpp"
#include "tests/gpu/exact/queries.hpp"

namespace collided::test {
namespace {

using exact::Contact;
using exact::Form;
using exact::fixed::Outcome;

constexpr ContactKind kKinds[] = {ContactKind::kVertexTriangle, ContactKind::kEdgeEdge};

Point any_point(std::mt19937_64& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  const double x = number(random), y = number(random), z = number(random);
  return {x, y, z};
}

Contact in_any_size(ContactKind kind, const Query& q) {
  return exact::contact_in_any_size(kind, q.start, q.end, q.thickness);
}

void expect_same(const ExactImpact& found, const ExactImpact& expected) {
  EXPECT_EQ(found.hit, expected.hit);
  EXPECT_EQ(found.initial, expected.initial);
  EXPECT_EQ(found.toi, expected.toi);
}

/// Scaled about `centre`, each coordinate rounded to Real.
template <class Real>
Query about(const Point& centre, double scale, std::mt19937_64& random) {
  const auto rounded = [](double x) {
    volatile Real narrow = static_cast<Real>(x);  // see through_float in tests/support/case.cpp
    return static_cast<double>(narrow);
  };
  const auto by = [&](double x, double c) { return rounded(c + scale * (x - c)); };
  Query q;
  for (int i = 0; i < 4; ++i) {
    const Point p = any_point(random);
    q.start[i] = {rounded(p.x), rounded(p.y), rounded(p.z)};
    q.end[i] = {by(q.start[i].x, centre.x), by(q.start[i].y, centre.y), by(q.start[i].z, centre.z)};
  }
  return q;
}

// Integers of fixed size decide them all, where they left all open before.
TEST(ScaledFeatures, AreDecidedInFixedSize) {
  std::mt19937_64 random(3);
  for (const double scale : {-2.0, -0.25, 0.0, 0.5, 1.0, 4.0})
    for (int i = 0; i < 25; ++i)
      for (const ContactKind kind : kKinds) {
        const Query q = about<double>(kOrigin, scale, random);
        const exact::fixed::Verdict found = exact::fixed::decide(kind, q.start, q.end);
        EXPECT_EQ(found.outcome, scale < 0 ? Outcome::kBetween : scale == 0 ? Outcome::kAtEnd : Outcome::kApart);
        expect_same({scale <= 0, found.toi, false}, exact::first_impact(in_any_size(kind, q)));
      }
}

template <class Real>
void expect_clusters_decided() {
  std::mt19937_64 random(4);
  int open = 0, hits = 0;
  for (int i = 0; i < 150; ++i)
    for (const ContactKind kind : kKinds) {
      const Query q = about<Real>({.1, .2, .3}, i % 2 == 0 ? -1.7 : -0.3, random);
      const exact::fixed::Verdict found = exact::fixed::decide(kind, q.start, q.end);
      open += found.outcome == Outcome::kOpen ? 1 : 0;
      if (found.outcome == Outcome::kOpen) continue;
      const bool hit = found.outcome != Outcome::kApart;
      hits += hit ? 1 : 0;
      expect_same({hit, found.toi, false}, exact::first_impact(in_any_size(kind, q)));
    }
  EXPECT_LT(open, 15) << "of 300";
  EXPECT_GT(hits, 50);
}

// Rounding parts the three times at which they would meet in one point.
TEST(ScaledFeatures, AndRoundedToDoubleAreDecidedInFixedSize) { expect_clusters_decided<double>(); }
TEST(ScaledFeatures, AndRoundedToFloatAreDecidedInFixedSize) { expect_clusters_decided<float>(); }

/// Features in the planes z = 0 and z = 1/2 of a lattice of eighths, which move within their planes.
Query in_two_planes(ContactKind kind, std::mt19937_64& random) {
  std::uniform_int_distribution<int> place(-8, 8);
  Query q;
  q.thickness = 0.5;
  for (int i = 0; i < 4; ++i) {
    const bool is_first = i < (kind == ContactKind::kVertexTriangle ? 1 : 2);
    q.start[i] = {place(random) / 8.0, place(random) / 8.0, is_first ? 0.5 : 0.0};
    q.end[i] = {place(random) / 8.0, place(random) / 8.0, is_first ? 0.5 : 0.0};
  }
  return q;
}

TEST(AtTheThickness, FormsOfFixedSizeAreThoseOfAnySize) {
  std::mt19937_64 random(6);
  int hits = 0, initial = 0;
  for (int i = 0; i < 80; ++i)
    for (const ContactKind kind : kKinds) {
      const Query q = in_two_planes(kind, random);
      for (const int exponent : {0, 40}) {  // one limb, and two
        Query stretched = changed(q, [&](const Point& p, bool) { return Point{p.x, std::ldexp(p.y, exponent), p.z}; });
        if (exponent != 0) stretched.start[3].x += 0x1p-30;
        const ExactImpact expected = exact::first_impact(in_any_size(kind, stretched));
        hits += expected.hit ? 1 : 0;
        initial += expected.initial ? 1 : 0;
        expect_same(impact(kind == kKinds[0] ? ccd<kKinds[0]> : ccd<kKinds[1]>, stretched), expected);
        const bool at_rest = exact::holds_at_start(
            exact::contact_at_rest(kind, stretched.start, stretched.thickness));
        EXPECT_EQ(exact_proximity(kind, stretched.start, stretched.thickness), at_rest);
      }
    }
  EXPECT_GT(initial, 20);
  EXPECT_GT(hits, initial + 20);
}

/// A form with coefficients of any exponents, or a product of lines with such coefficients.
Form any_form(std::mt19937_64& random) {
  const auto number = [&] {
    const exact::Number n = static_cast<int64_t>(random() >> 11 | 1);
    return (random() % 2 == 0 ? n : -n) << (random() % 3000);
  };
  Form f;
  f.c[0] = number();
  const size_t degree = 1 + random() % 6;
  const bool is_product = random() % 2 == 0;
  for (size_t i = 0; i < degree; ++i) {
    Form line;
    line.c = {number(), number()};
    if (is_product)
      f = f * line;
    else
      f.c.push_back(number());
  }
  return f;
}

TEST(RootsInDoublePrecision, AreTheExactOnes) {
  std::mt19937_64 random(7);
  int found = 0, signs = 0, times = 0;
  for (int i = 0; i < 400; ++i) {
    const Form f = any_form(random), g = any_form(random);
    std::vector<exact::Root> expected = exact::roots_inside(f);
    const std::optional<exact::RoughForm> rough = exact::RoughForm::of(exact::without_roots_at_ends(f));
    std::optional<std::vector<exact::RoughRoot>> roots = exact::rough_roots(*rough);
    if (!roots) continue;
    ASSERT_EQ(roots->size(), expected.size()) << i;
    for (size_t k = 0; k < roots->size(); ++k) {
      ++found;
      exact::RoughRoot& root = (*roots)[k];
      if (const int sign = root.sign_of(*exact::RoughForm::of(g)); sign != exact::RoughForm::kUnknown) {
        ++signs;
        EXPECT_EQ(sign, expected[k].sign_of(g));
      }
      EXPECT_GE(expected[k].may_rise(), root.may_rise());
      const std::optional<double> time = root.rounded_down();
      times += time ? 1 : 0;
      EXPECT_EQ(time.value_or(expected[k].rounded_down()), expected[k].rounded_down());
      if (std::optional<exact::Root> same = root.exact(exact::without_roots_at_ends(f))) {
        EXPECT_EQ(same->rounded_down(), expected[k].rounded_down());
      }
    }
  }
  EXPECT_GT(found, 200);
  EXPECT_GT(signs, 150);
  EXPECT_GT(times, 100);
}

Query exponents_far_apart(std::mt19937_64& random) {
  std::uniform_int_distribution<int> exponent(-1000, 1000);
  return changed({}, [&](const Point&, bool) {
    const Point p = any_point(random);
    const int x = exponent(random), y = exponent(random), z = exponent(random);
    return Point{std::ldexp(p.x, x), std::ldexp(p.y, y), std::ldexp(p.z, z)};
  });
}

// Integers of thousands of bits take a hundred times as long.
TEST(ExponentsFarApart, AreMostlyDecidedWithoutIntegers) {
  std::mt19937_64 random(9);
  int left_open = 0, hits = 0;
  for (int i = 0; i < 150; ++i)
    for (const ContactKind kind : kKinds)
      for (const double thickness : {0.0, 0.01}) {
        Query q = exponents_far_apart(random);
        q.thickness = thickness;
        const Contact contact = in_any_size(kind, q);
        if (exact::holds_at_start(contact)) continue;
        const std::optional<exact::CertainImpact> certain = exact::certain_impact(contact);
        left_open += certain && certain->open.empty() ? 0 : 1;
        hits += certain && certain->time < exact::kNever ? 1 : 0;
      }
  EXPECT_LT(left_open, 30) << "of 600";
  EXPECT_GT(hits, 50);
}

// What is left out has no time at which the form is above 0.
TEST(WindowsOfAForm, LeaveOutNoTimeAtWhichItIsNotNegative) {
  std::mt19937_64 random(8);
  int empty = 0;
  for (int i = 0; i < 300; ++i) {
    const Form f = any_form(random);
    exact::Windows windows;
    windows.need_not_negative(exact::LazyForm(f));
    if (!windows.are_empty()) continue;
    ++empty;
    EXPECT_TRUE(exact::roots_inside(f).empty());
    EXPECT_LT(exact::first_sign(f), 0);
  }
  EXPECT_GT(empty, 20);
}

}  // namespace
}  // namespace collided::test
