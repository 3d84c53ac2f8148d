// Polynomials whose roots are known.

#include "tests/support/judge/exact_root.hpp"

#include <gtest/gtest.h>

namespace collided::test {
namespace {

// denominator * t - numerator
Polynomial root_at(int numerator, int denominator) { return {-numerator, denominator}; }

const Polynomial kHalfRoot{-1, 0, 2};  // 2 t^2 - 1: the root of 1/2, irrational

TEST(ExactRoot, FindsEachRootOnceInOrder) {
  const Polynomial p = root_at(1, 3) * root_at(1, 3) * root_at(1, 2) * root_at(2, 3) * root_at(3, 2) * root_at(-1, 2);
  std::vector<Root> roots = roots_in_unit_interval(p);
  ASSERT_EQ(roots.size(), 3u);
  const mpq_class expected[] = {mpq_class(1, 3), mpq_class(1, 2), mpq_class(2, 3)};
  for (int i = 0; i < 3; ++i) {
    roots[i].refine(60);
    EXPECT_LE(roots[i].lower(), expected[i]);
    EXPECT_GE(roots[i].upper(), expected[i]);
    EXPECT_LE(mpq_class((roots[i].upper() - roots[i].lower()) * mpq_class(mpz_class(1) << 60)), 1);
  }
}

TEST(ExactRoot, EndsOfTheIntervalCount) {
  const std::vector<Root> roots = roots_in_unit_interval(root_at(0, 1) * root_at(1, 1) * root_at(1, 1) * root_at(5, 4));
  ASSERT_EQ(roots.size(), 2u);
  EXPECT_TRUE(roots[0].is_fraction());
  EXPECT_EQ(roots[0].lower(), 0);
  EXPECT_TRUE(roots[1].is_fraction());
  EXPECT_EQ(roots[1].lower(), 1);
}

TEST(ExactRoot, NoRootsWhereThereAreNone) {
  EXPECT_TRUE(roots_in_unit_interval({}).empty());
  EXPECT_TRUE(roots_in_unit_interval({7}).empty());
  EXPECT_TRUE(roots_in_unit_interval({1, 0, 1}).empty());
  EXPECT_TRUE(roots_in_unit_interval({-2, 0, 1}).empty());  // the root of 2
  // (t - 1/2)^2 + 2^-80: nearly a root
  EXPECT_TRUE(
      roots_in_unit_interval(Polynomial{(mpz_class(1) << 78) + 1, -(mpz_class(1) << 80), mpz_class(1) << 80}).empty());
}

TEST(ExactRoot, TellsRootsApartThatAreClose) {
  const mpz_class big = mpz_class(1) << 100;
  const Polynomial p = Polynomial{-big, 3 * big} * Polynomial{-big, 3 * big + 1};
  std::vector<Root> roots = roots_in_unit_interval(p);
  ASSERT_EQ(roots.size(), 2u);
  EXPECT_EQ(roots[0].sign_of(root_at(1, 3)), -1);
  EXPECT_EQ(roots[1].sign_of(root_at(1, 3)), 0);
}

TEST(ExactRoot, SignsAtAnIrrationalRoot) {
  std::vector<Root> roots = roots_in_unit_interval(kHalfRoot);
  ASSERT_EQ(roots.size(), 1u);
  EXPECT_EQ(roots[0].sign_of({}), 0);
  EXPECT_EQ(roots[0].sign_of({-5}), -1);
  EXPECT_EQ(roots[0].sign_of(kHalfRoot * kHalfRoot), 0);
  EXPECT_EQ(roots[0].sign_of(kHalfRoot * root_at(7, 10)), 0);
  EXPECT_EQ(roots[0].sign_of(root_at(7, 10)), 1);
  EXPECT_EQ(roots[0].sign_of(root_at(71, 100)), -1);
  // 2 t^2 - 1 - 2^-200 t: the gcd has to say that this is not 0
  const mpz_class big = mpz_class(1) << 200;
  EXPECT_EQ(roots[0].sign_of(Polynomial{-big, -1, 2 * big}), -1);
}

TEST(ExactRoot, SignChangesBoundRoots) {
  EXPECT_EQ(sign_changes({1, 1}), 0);
  EXPECT_EQ(sign_changes({-1, 2}), 1);
  EXPECT_EQ(sign_changes({0, 1}), 0);  // a root at the end is not inside
  EXPECT_EQ(sign_changes(root_at(1, 3) * root_at(2, 3)), 2);
}

TEST(ExactPolynomial, GcdAndSquareFreePart) {
  const Polynomial a = root_at(1, 3) * root_at(1, 3) * kHalfRoot, b = root_at(1, 3) * root_at(2, 3);
  EXPECT_EQ(gcd(a, b).degree(), 1);
  EXPECT_EQ(gcd(kHalfRoot, b).degree(), 0);
  EXPECT_EQ(gcd(Polynomial{}, b).degree(), 2);
  EXPECT_EQ(square_free(a).degree(), 3);
  EXPECT_EQ(square_free(b).degree(), 2);
}

}  // namespace
}  // namespace collided::test
