#pragma once
// Roots in [0, 1] of the coplanarity cubic (Provot 1997; Bridson, Fedkiw and Anderson 2002): intervals between
// the extrema are monotone, and bisection in each ends on neighbouring numbers. Working precision, no guarantee.

#include <cmath>

#include "gpu/base/vec3.hpp"

namespace collided {

/// f(t) = c0 + c1 t + c2 t^2 + c3 t^3 with its Bernstein coefficients (b1, b2 times three).
template <class Real>
struct Cubic {
  Real c0, c1, c2, c3;
  Real b0, b1x3, b2x3, b3;

  COLLIDED_HD Real operator()(Real t) const { return ((c3 * t + c2) * t + c1) * t + c0; }
  /// All Bernstein coefficients on one side of zero: no root in [0, 1], but for rounding.
  COLLIDED_HD bool one_sided() const {
    return (b0 > 0 && b1x3 > 0 && b2x3 > 0 && b3 > 0) || (b0 < 0 && b1x3 < 0 && b2x3 < 0 && b3 < 0);
  }
};

/// Determinant of three vectors that move linearly from x to y.
template <class Real>
COLLIDED_HD Cubic<Real> moving_triple(const Vec3<Real> (&x)[3], const Vec3<Real> (&y)[3]) {
  const Vec3<Real> xx = cross(x[0], x[1]), yy = cross(y[0], y[1]);
  const Vec3<Real> mixed = cross(x[0], y[1]) + cross(y[0], x[1]);
  Cubic<Real> f;
  f.b0 = dot(xx, x[2]);
  f.b1x3 = dot(xx, y[2]) + dot(mixed, x[2]);
  f.b2x3 = dot(yy, x[2]) + dot(mixed, y[2]);
  f.b3 = dot(yy, y[2]);
  f.c0 = f.b0;
  f.c1 = f.b1x3 - 3 * f.b0;
  f.c2 = f.b2x3 - 2 * f.b1x3 + 3 * f.b0;
  f.c3 = f.b3 - f.b2x3 + f.b1x3 - f.b0;
  return f;
}

/// The extrema of f inside (0, 1), ascending; returns how many.
template <class Real>
COLLIDED_HD int extrema(const Cubic<Real>& f, Real (&at)[2]) {
  const Real a = 3 * f.c3, half_b = f.c2, c = f.c1;
  const Real discriminant = half_b * half_b - a * c;
  if (!(discriminant >= 0)) return 0;
  const Real q = -(half_b + (half_b < 0 ? -std::sqrt(discriminant) : std::sqrt(discriminant)));
  int n = 0;
  if (a != 0 && q / a > 0 && q / a < 1) at[n++] = q / a;
  if (q != 0 && c / q > 0 && c / q < 1) at[n++] = c / q;
  if (n == 2 && at[1] < at[0]) {
    const Real swap = at[0];
    at[0] = at[1];
    at[1] = swap;
  }
  return n;
}

/// Lower end of the last bracket of a sign change between l and r.
template <class Real>
COLLIDED_HD Real bisect(const Cubic<Real>& f, Real l, Real r) {
  const bool left_negative = f(l) < 0;
  constexpr int kHalvings = 80;  // neighbouring numbers, except within 2^-80 of zero
  for (int i = 0; i < kHalvings; ++i) {
    const Real middle = l + (r - l) / 2;
    if (!(middle > l && middle < r)) return l;
    if ((f(middle) < 0) == left_negative)
      l = middle;
    else
      r = middle;
  }
  return l;
}

/// Ascending roots of f in [0, 1]; returns how many (at most three).
template <class Real>
COLLIDED_HD int roots_in_unit(const Cubic<Real>& f, Real (&roots)[3]) {
  Real ends[4] = {Real(0), Real(1), Real(1), Real(1)};
  Real at[2];
  const int extremum_count = extrema(f, at);
  for (int i = 0; i < extremum_count; ++i) ends[i + 1] = at[i];
  int n = 0;
  for (int i = 0; i <= extremum_count; ++i) {
    const Real l = ends[i], r = i == extremum_count ? Real(1) : ends[i + 1];
    const Real fl = f(l), fr = f(r);
    if (fl == 0)
      roots[n++] = l;
    else if (fr != 0 && (fl < 0) != (fr < 0))
      roots[n++] = bisect(f, l, r);
  }
  return n;
}

}  // namespace collided
