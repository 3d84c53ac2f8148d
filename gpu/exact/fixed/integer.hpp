#pragma once
// Integers of a fixed number of 64-bit limbs, without memory of their own. A product is as wide as both factors
// together, so that none overflows; sums have to fit (the bounds are in differences.hpp).

#include <bit>

#include "gpu/base/rounding.hpp"
#include "gpu/base/vec3.hpp"

namespace collided::exact::fixed {

__extension__ using Double = unsigned __int128;  ///< a product of two limbs

/// Two's complement, the lowest limb first.
template <int N>
struct Integer {
  uint64_t limb[N];

  COLLIDED_HD static Integer of(int64_t x) {
    Integer r;
    r.limb[0] = static_cast<uint64_t>(x);
    for (int i = 1; i < N; ++i) r.limb[i] = x < 0 ? ~uint64_t{0} : 0;
    return r;
  }
  COLLIDED_HD bool is_negative() const { return (limb[N - 1] >> 63) != 0; }
  COLLIDED_HD bool is_zero() const {
    uint64_t any = 0;
    for (int i = 0; i < N; ++i) any |= limb[i];
    return any == 0;
  }
  COLLIDED_HD int sign() const { return is_negative() ? -1 : is_zero() ? 0 : 1; }
};

template <int N>
COLLIDED_HD Integer<N> operator+(const Integer<N>& a, const Integer<N>& b) {
  Integer<N> r;
  Double sum = 0;
  for (int i = 0; i < N; ++i) {
    sum = (sum >> 64) + a.limb[i] + b.limb[i];
    r.limb[i] = static_cast<uint64_t>(sum);
  }
  return r;
}
template <int N>
COLLIDED_HD Integer<N> operator-(const Integer<N>& a, const Integer<N>& b) {
  Integer<N> r;
  Double sum = Double{1} << 64;  // a + ~b + 1
  for (int i = 0; i < N; ++i) {
    sum = (sum >> 64) + a.limb[i] + ~b.limb[i];
    r.limb[i] = static_cast<uint64_t>(sum);
  }
  return r;
}

template <int N>
COLLIDED_HD Integer<N> operator-(const Integer<N>& a) {
  return Integer<N>::of(0) - a;
}

/// b from a's limb `at` on is taken from a, modulo 2^(64 N).
template <int N, int M>
COLLIDED_HD void subtract_above(Integer<N>& a, const Integer<M>& b, int at) {
  Double sum = Double{1} << 64;
  for (int i = at; i < N; ++i) {
    sum = (sum >> 64) + a.limb[i] + ~b.limb[i - at];
    a.limb[i] = static_cast<uint64_t>(sum);
  }
}

// Of the limbs as numbers without signs; a negative factor was taken for 2^(64 N) more than it is.
template <int N, int M>
COLLIDED_HD COLLIDED_CALLED Integer<N + M> operator*(const Integer<N>& a, const Integer<M>& b) {
  Integer<N + M> r = Integer<N + M>::of(0);
  for (int i = 0; i < N; ++i) {
    Double sum = 0;
    for (int j = 0; j < M; ++j) {
      sum = (sum >> 64) + r.limb[i + j] + Double{a.limb[i]} * b.limb[j];
      r.limb[i + j] = static_cast<uint64_t>(sum);
    }
    r.limb[i + M] = static_cast<uint64_t>(sum >> 64);
  }
  if (a.is_negative()) subtract_above(r, b, N);
  if (b.is_negative()) subtract_above(r, a, M);
  return r;
}

/// The same number in another count of limbs, which it has to fit.
template <int To, int N>
COLLIDED_HD Integer<To> resized(const Integer<N>& a) {
  Integer<To> r;
  for (int i = 0; i < To; ++i) r.limb[i] = i < N ? a.limb[i] : a.is_negative() ? ~uint64_t{0} : 0;
  return r;
}

/// a / 2^bits, which divides it.
template <int N>
COLLIDED_HD Integer<N> shifted_right(const Integer<N>& a, int bits) {
  const int limbs = bits / 64, rest = bits % 64;
  const uint64_t fill = a.is_negative() ? ~uint64_t{0} : 0;
  Integer<N> r;
  for (int i = 0; i < N; ++i) {
    const uint64_t low = i + limbs < N ? a.limb[i + limbs] : fill;
    const uint64_t high = i + limbs + 1 < N ? a.limb[i + limbs + 1] : fill;
    r.limb[i] = rest == 0 ? low : (low >> rest) | (high << (64 - rest));
  }
  return r;
}

COLLIDED_HD inline int trailing_zeros(uint64_t x) {
#ifdef __CUDA_ARCH__
  return __ffsll(static_cast<long long>(x)) - 1;
#else
  return std::countr_zero(x);
#endif
}
COLLIDED_HD inline int leading_zeros(uint64_t x) {
#ifdef __CUDA_ARCH__
  return __clzll(static_cast<long long>(x));
#else
  return std::countl_zero(x);
#endif
}
/// Returns how often 2 divides a number that is not 0.
template <int N>
COLLIDED_HD int trailing_zeros(const Integer<N>& a) {
  int i = 0;
  while (a.limb[i] == 0) ++i;
  return 64 * i + trailing_zeros(a.limb[i]);
}
/// Returns the bits of a number above 0.
template <int N>
COLLIDED_HD int used_bits(const Integer<N>& a) {
  int i = N - 1;
  while (a.limb[i] == 0) --i;
  return 64 * (i + 1) - leading_zeros(a.limb[i]);
}

/// Returns |a| rounded toward 0 to 53 bits.
template <int N>
COLLIDED_HD Integer<N> leading_bits(const Integer<N>& a) {
  if (a.is_zero()) return a;
  Integer<N> r = a.is_negative() ? -a : a;
  int surplus = used_bits(r) - 53;
  for (int i = 0; i < N && surplus > 0; ++i, surplus -= 64)
    r.limb[i] = surplus >= 64 ? 0 : r.limb[i] >> surplus << surplus;
  return r;
}

/// a within 2^-51 of its magnitude.
template <int N>
COLLIDED_HD double to_double(const Integer<N>& a) {
  const Integer<N> size = a.is_negative() ? -a : a;
  double value = 0, unit = 1;
  for (int i = 0; i < N; ++i, unit *= 0x1p64) value += static_cast<double>(size.limb[i]) * unit;
  return a.is_negative() ? -value : value;
}

/// Returns |a| / |b|, where |a| <= |b|, both rounded toward 0 to 53 bits. The result depends neither on the number of
/// limbs nor on the unit. Number has the same function.
template <int N, int M>
COLLIDED_HD double ratio(const Integer<N>& a, const Integer<M>& b) {
  return to_double(leading_bits(a)) / to_double(leading_bits(b));
}

/// Cross and dot products may have components of another type than their factors.
template <class A, class B>
COLLIDED_HD auto wide_cross(const Vec3<A>& a, const Vec3<B>& b) {
  return Vec3<decltype(a.x * b.x)>{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class A, class B>
COLLIDED_HD auto wide_dot(const Vec3<A>& a, const Vec3<B>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <int N>
COLLIDED_HD Vec3<double> to_double(const Vec3<Integer<N>>& a) {
  return {to_double(a.x), to_double(a.y), to_double(a.z)};
}
template <class Int>
COLLIDED_HD bool is_zero(const Vec3<Int>& a) {
  return a.x.is_zero() && a.y.is_zero() && a.z.is_zero();
}

}  // namespace collided::exact::fixed
