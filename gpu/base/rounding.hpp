#pragma once
// Rounding outward, from bits alone: the same on every backend.

#include <cstring>

#include "gpu/base/host_device.hpp"

namespace collided {

namespace detail {
template <class Real>
struct Bits;
template <>
struct Bits<float> {
  using Type = uint32_t;
  static constexpr Type kSign = 0x80000000u, kInfinity = 0x7f800000u;
};
template <>
struct Bits<double> {
  using Type = uint64_t;
  static constexpr Type kSign = 0x8000000000000000u, kInfinity = 0x7ff0000000000000u;
};

template <class To, class From>
COLLIDED_HD To bit_copy(const From& from) {
  To to;
  static_assert(sizeof(to) == sizeof(from));
  memcpy(&to, &from, sizeof(to));
  return to;
}
}  // namespace detail

/// Least number above x; infinity stays.
template <class Real>
COLLIDED_HD Real next_up(Real x) {
  using B = detail::Bits<Real>;
  using Type = typename B::Type;
  Type bits = detail::bit_copy<Type>(x);
  if (bits == B::kInfinity) return x;
  if ((bits & ~B::kSign) == 0) return detail::bit_copy<Real>(Type{1});
  bits = (bits & B::kSign) != 0 ? bits - 1 : bits + 1;
  return detail::bit_copy<Real>(bits);
}
template <class Real>
COLLIDED_HD Real next_down(Real x) {
  return -next_up(-x);
}
/// a + b, rounded up or down; exact where one of them is 0.
COLLIDED_HD inline double sum_above(double a, double b) { return a == 0 ? b : b == 0 ? a : next_up(a + b); }
COLLIDED_HD inline double sum_below(double a, double b) { return a == 0 ? b : b == 0 ? a : next_down(a + b); }

/// Greatest float not above x, least float not below x.
COLLIDED_HD inline float float_below(float x) { return x; }
COLLIDED_HD inline float float_above(float x) { return x; }
COLLIDED_HD inline float float_below(double x) {
  const float f = static_cast<float>(x);
  return static_cast<double>(f) > x ? next_down(f) : f;
}
COLLIDED_HD inline float float_above(double x) {
  const float f = static_cast<float>(x);
  return static_cast<double>(f) < x ? next_up(f) : f;
}

}  // namespace collided
