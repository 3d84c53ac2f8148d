// Integers of any size against GMP's own.

#include "gpu/exact/number.hpp"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <random>

namespace collided::test {
namespace {

using exact::Number;

mpz_class value(const Number& a) {
  mpz_t view;
  return mpz_class(a.view(view));
}

/// Of up to 40 limbs, many of which are 0 or all ones; often small, sometimes 0.
mpz_class any_integer(std::mt19937_64& random) {
  mpz_class n;
  const uint64_t limbs = random() % 3 == 0 ? random() % 40 : random() % 4;
  for (uint64_t i = 0; i < limbs; ++i) {
    const uint64_t choice = random() % 4;
    n <<= 64;
    n += static_cast<unsigned long>(choice == 0 ? 0 : choice == 1 ? ~uint64_t{0} : random());
  }
  return random() % 2 == 0 ? n : mpz_class(-n);
}

TEST(Number, ComputesAsGmp) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 4000; ++i) {
    const mpz_class x = any_integer(random), y = any_integer(random), z = any_integer(random);
    const Number a = Number::of(x.get_mpz_t()), b = Number::of(y.get_mpz_t()), c = Number::of(z.get_mpz_t());
    const auto bits = static_cast<mp_bitcnt_t>(random() % 300);
    ASSERT_EQ(value(a), x);
    ASSERT_EQ(value(a + b), x + y);
    ASSERT_EQ(value(a - b), x - y);
    ASSERT_EQ(value(-a), -x);
    ASSERT_EQ(value(a * b), x * y);
    ASSERT_EQ(value(a << bits), x << bits);
    ASSERT_EQ(value(a >> bits), x / (mpz_class(1) << bits)) << "toward 0";
    Number sum = c;
    sum.add_product(a, b);
    ASSERT_EQ(value(sum), z + x * y);
    ASSERT_EQ(sgn(a), sgn(x));
    ASSERT_EQ(a == b, x == y);
    ASSERT_EQ(a.bits(), x == 0 ? 0 : mpz_sizeinbase(x.get_mpz_t(), 2));
    ASSERT_EQ(a.to_double(), x.get_d());
    ASSERT_EQ(value(common_divisor(a, b)), gcd(x, y));
    if (y == 0) continue;
    ASSERT_EQ(value(a / b), x / y);
    ASSERT_EQ(value(exact_quotient(a * b, b)), x);
    ASSERT_EQ(b.trailing_zeros(), mpz_scan1(y.get_mpz_t(), 0));
  }
}

TEST(Number, OfItself) {
  for (const int64_t x : {int64_t{0}, int64_t{-3}, INT64_MAX, INT64_MIN}) {
    Number a = x, b = x;
    EXPECT_EQ(value(a), mpz_class(static_cast<long>(x)));
    a += a;
    EXPECT_EQ(value(a), 2 * mpz_class(static_cast<long>(x)));
    b -= b;
    EXPECT_EQ(value(b), 0);
  }
  const Number large = Number(7) << 5000;
  Number moved = large, other = std::move(moved);
  EXPECT_EQ(other, large);
  moved = std::move(other);
  EXPECT_EQ(moved, large);
  moved = moved * moved;
  EXPECT_EQ(value(moved), mpz_class(49) << 10000);
}

}  // namespace
}  // namespace collided::test
