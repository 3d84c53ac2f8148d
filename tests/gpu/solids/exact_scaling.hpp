#pragma once
// Converts positions to integers and back.

#include <cmath>
#include <cstdint>

#include "gpu/types.hpp"
#include "tests/gpu/solids/exact_vectors.hpp"

namespace collided::test {

/// The exponent of the lowest bit of a number that is not 0.
inline int lowest_bit(double x) {
  int exponent;
  auto bits = static_cast<int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
  exponent -= 53;
  for (; bits % 2 == 0; bits /= 2) ++exponent;
  return exponent;
}
/// In units of 2^exponent.
template <class N>
Vector<N> as_integers(const Vec3d& p, int exponent) {
  Vector<N> out;
  for (size_t k = 0; k < 3; ++k) {
    int of_p;
    out[k] = static_cast<int64_t>(std::ldexp(std::frexp(p[k], &of_p), 53));
    const int shift = p[k] == 0 ? 0 : of_p - 53 - exponent;
    if (shift > 0) out[k] <<= static_cast<unsigned>(shift);
    if (shift < 0) out[k] >>= static_cast<unsigned>(-shift);  // bits that are 0
  }
  return out;
}

/// x, within 2^-63 of its size.
inline long double rounded(const mpz_class& x) {
  const size_t bits = mpz_sizeinbase(x.get_mpz_t(), 2);
  if (bits <= 64) return static_cast<long double>(mpz_get_ui(x.get_mpz_t())) * sgn(x);
  const mpz_class top = abs(x) >> (bits - 64);
  return std::ldexp(static_cast<long double>(mpz_get_ui(top.get_mpz_t())), static_cast<int>(bits - 64)) * sgn(x);
}
template <class N>
long double root_of(const Fraction<N>& squared) {
  const mpz_class over = big(squared.over), under = big(squared.under);
  const auto bits = [](const mpz_class& x) { return static_cast<int>(mpz_sizeinbase(x.get_mpz_t(), 2)); };
  const int half = std::max(0, 70 + (bits(under) - bits(over)) / 2);
  const mpz_class shifted = (over << static_cast<unsigned>(2 * half)) / under;
  return std::ldexp(rounded(sqrt(shifted)), -half);
}

}  // namespace collided::test
