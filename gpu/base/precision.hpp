#pragma once
// Constants of the error bounds, which are derived where they are used: for one rounding of a sum, product, quotient
// or root, fl(x) = x (1 + d) + e with |d| <= kUnit, and e = 0 but for products and quotients that underflow, where |e|
// is far below kTiny.

#include <type_traits>

#include "gpu/base/rounding.hpp"

namespace collided {

template <class Real>
struct Precision;
template <>
struct Precision<float> {
  static constexpr float kUnit = 0x1p-24f;
  static constexpr float kTiny = 0x1p-120f;  ///< 64 times the least normal number
};
template <>
struct Precision<double> {
  static constexpr double kUnit = 0x1p-53;
  static constexpr double kTiny = 0x1p-1016;
};

template <class A, class B>
using Wider = std::conditional_t<(sizeof(A) > sizeof(B)), A, B>;

/// Power of two that brings x > 0 into [1, 2); numbers below the least normal one stay below 2. x must be at most an
/// eighth of the largest number.
COLLIDED_HD inline float unit_scale(float x) {
  const uint32_t exponent = detail::bit_copy<uint32_t>(x) >> 23;
  return detail::bit_copy<float>((254u - exponent) << 23);
}
COLLIDED_HD inline double unit_scale(double x) {
  const uint64_t exponent = detail::bit_copy<uint64_t>(x) >> 52;
  return detail::bit_copy<double>((uint64_t{2046} - exponent) << 52);
}

/// Least number of the working type that is not below x.
template <class Work>
COLLIDED_HD Work round_up(double x) {
  if constexpr (std::is_same_v<Work, float>)
    return float_above(x);
  else
    return x;
}

/// thickness * scale, rounded up.
template <class Work>
COLLIDED_HD Work scaled_thickness(double thickness, double scale) {
  const double product = thickness * scale;
  return thickness > 0 ? round_up<Work>(next_up(product)) : Work(0);  // the product may have underflown
}

}  // namespace collided
