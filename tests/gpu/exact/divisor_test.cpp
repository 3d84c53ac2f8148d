// Common divisors of polynomials that are made of known factors.

#include "gpu/exact/roots/divisor.hpp"

#include <gtest/gtest.h>

#include <random>

namespace collided::test {
namespace {

using exact::Form;

constexpr long kPrime = 2147483647;  ///< that a first look at the polynomials is modulo of

Form form(std::initializer_list<long> coefficients) {
  Form f;
  f.c.assign(coefficients.begin(), coefficients.end());
  return f;
}
/// Without common factors of the coefficients, and of one sign.
void expect_divisor(const Form& a, const Form& b, const Form& expected) {
  for (const Form& found : {exact::common_divisor(a, b), exact::common_divisor(b, a)}) {
    EXPECT_EQ(found.degree(), expected.degree());
    if (expected.degree() == 0 || found.degree() != expected.degree()) continue;
    EXPECT_TRUE(found.c == expected.c || (-found).c == expected.c);
  }
}

TEST(CommonDivisor, OfKnownFactors) {
  const Form f = form({3, -7, 2}), g = form({-1, 5}), h = form({11, 0, 0, 13}), one = form({1});
  expect_divisor(f * g, h, one);
  expect_divisor(f * g, g * h, g);
  expect_divisor(f * f * g, f * h, f);
  expect_divisor(f * h, f * h, f * h);
  expect_divisor(form({0, 0}), g, g);
  expect_divisor(form({5}), g, one);
}

// Modulo the prime these have other degrees, or are 0, or have divisors that they do not have.
TEST(CommonDivisor, WhateverThePrimeHides) {
  const Form hidden = form({1, kPrime}), zero = form({kPrime, 2 * kPrime}), f = form({3, -7, 2});
  expect_divisor(f * hidden, hidden * form({1, 1}), hidden);
  expect_divisor(f * hidden, f, f);
  expect_divisor(zero * f, f * form({2, 5}), f);
  expect_divisor(form({1, 1}), form({1 + kPrime, 1}), form({1}));
  expect_divisor(form({1, 0, 0, 0}), form({1, 1, 0}), form({1}));
}

TEST(CommonDivisor, OfLargeCoefficients) {
  std::mt19937_64 random(3);
  const auto large = [&](size_t degree) {
    Form f;
    for (size_t k = 0; k <= degree; ++k) {
      const exact::Number x = static_cast<long>(random() >> 2 | 1);
      f.c.resize(degree + 1);
      f.c[k] = (x << (random() % 3000)) + 1;
    }
    return f;
  };
  for (int i = 0; i < 20; ++i) {
    const Form f = large(3), g = large(2), h = large(1);
    EXPECT_EQ(exact::common_divisor(f, g).degree(), 0u);
    EXPECT_EQ(exact::common_divisor(f * h, g * h).degree(), 1u);
    EXPECT_EQ(exact::square_free(f * h * h).degree(), 4u);
  }
}

}  // namespace
}  // namespace collided::test
