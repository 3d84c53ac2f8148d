#pragma once
// Intervals of t / s between places (rough.hpp), and how to cut them.

#include "gpu/exact/roots/rough.hpp"

namespace collided::exact {

/// Above all exponents of coefficients: beyond it forms keep their signs.
constexpr int64_t kFarthest = 40000;

/// Between two places: halfway in the exponent, or of two in one binary order or in neighbouring ones, in the middle.
inline RoughForm::Place between(const RoughForm::Place& a, const RoughForm::Place& b) {
  if (b.scale - a.scale > 1) return {a.scale + (b.scale - a.scale) / 2, 1.015625};
  const double last = b.scale == a.scale ? b.y : 2 * b.y, middle = a.y + (last - a.y) * 0.4921875;
  return middle < 2 ? RoughForm::Place{a.scale, middle} : RoughForm::Place{a.scale + 1, middle / 2};
}

/// `length`: in units of the power of two at a.
inline bool is_short(const RoughForm::Place& a, const RoughForm::Place& b, double length) {
  const int64_t scales = b.scale - a.scale;
  return scales == 0 ? b.y - a.y < length : scales == 1 && 2 * b.y - a.y < length;
}

}  // namespace collided::exact
