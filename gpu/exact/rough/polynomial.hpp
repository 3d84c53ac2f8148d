#pragma once
// Forms in long double. Its range holds products of six coordinates of any exponents, so nothing overflows or
// underflows. Where exponents lie far apart, one term of a sum mostly outweighs all others, and its sign is that of
// the sum: integers of thousands of bits would show no more.
//
// A number's size is the sum of its terms' magnitudes. With u = 2^-64, n roundings one after the other leave it within
// (1 + u)^n - 1 of its size. The forms of exact/features.cpp take at most 128 (94 where a way was cut twice,
// rough_motion.hpp; a contact distance is the sum of three numbers), so they are within 2^-57. A number that is not
// below kKnownShare of its size is known to 2^-52.

#include <limits>

#include "gpu/base/vec3.hpp"

namespace collided::exact {

static_assert(std::numeric_limits<long double>::digits >= 64 &&
              std::numeric_limits<long double>::max_exponent >= 16384);

constexpr long double kKnownShare = 0x1p-5L, kCertainShare = 0x1p-56L;  // above the latter, the sign is known

/// A size of 0: the number is 0.
struct RoughNumber {
  long double value = 0, size = 0;
};
inline RoughNumber rough(long double x) { return {x, magnitude(x)}; }
inline RoughNumber operator-(const RoughNumber& a) { return {-a.value, a.size}; }
inline RoughNumber operator+(const RoughNumber& a, const RoughNumber& b) {
  return {a.value + b.value, a.size + b.size};
}
inline RoughNumber operator-(const RoughNumber& a, const RoughNumber& b) {
  return {a.value - b.value, a.size + b.size};
}
inline RoughNumber operator*(const RoughNumber& a, const RoughNumber& b) {
  return {a.value * b.value, a.size * b.size};
}

/// sum of c[k] s^(degree - k) t^k.
template <int degree>
struct RoughPolynomial {
  RoughNumber c[degree + 1];
};

template <int degree>
RoughPolynomial<degree> operator+(const RoughPolynomial<degree>& a, const RoughPolynomial<degree>& b) {
  RoughPolynomial<degree> sum;
  for (int i = 0; i <= degree; ++i) sum.c[i] = a.c[i] + b.c[i];
  return sum;
}
template <int degree>
RoughPolynomial<degree> operator-(const RoughPolynomial<degree>& a, const RoughPolynomial<degree>& b) {
  RoughPolynomial<degree> difference;
  for (int i = 0; i <= degree; ++i) difference.c[i] = a.c[i] - b.c[i];
  return difference;
}
template <int degree>
RoughPolynomial<degree> operator-(const RoughPolynomial<degree>& a) {
  return RoughPolynomial<degree>{} - a;
}
template <int d1, int d2>
RoughPolynomial<d1 + d2> operator*(const RoughPolynomial<d1>& a, const RoughPolynomial<d2>& b) {
  RoughPolynomial<d1 + d2> product{};
  for (int i = 0; i <= d1; ++i)
    for (int j = 0; j <= d2; ++j) product.c[i + j] = product.c[i + j] + a.c[i] * b.c[j];
  return product;
}
template <int degree>
RoughPolynomial<degree> operator*(const RoughNumber& a, const RoughPolynomial<degree>& b) {
  return RoughPolynomial<0>{{a}} * b;
}

}  // namespace collided::exact
