#pragma once
// The volume of four moving points as a cubic in t, and its one root.

#include "gpu/exact/fixed/differences.hpp"

namespace collided::exact::fixed {

/// Times are multiples of 2^-60 here.
constexpr int kTimeBits = 60;
constexpr uint64_t kOne = uint64_t{1} << kTimeBits;

/// t and 1 - t, both times 2^60.
struct Time {
  Integer<1> t, s;
  COLLIDED_HD explicit Time(uint64_t k)
      : t(Integer<1>::of(static_cast<int64_t>(k))), s(Integer<1>::of(static_cast<int64_t>(kOne - k))) {}
};

/// c[0] s^3 + c[1] s^2 t + c[2] s t^2 + c[3] t^3, with s = 1 - t.
template <int N>
struct Cubic {
  Integer<N> c[4];

  COLLIDED_HD Integer<N + 3> at(uint64_t k) const {
    const Time time(k);
    const auto ss = time.s * time.s;
    const auto high = (c[3] * time.t + c[2] * time.s) * time.t + c[1] * ss;
    return high * time.t + c[0] * (ss * time.s);
  }
};

/// How often the signs change, zeros left out: the number of roots in (0, 1), or two more.
template <int N>
COLLIDED_HD int sign_changes(const Cubic<N>& f) {
  int changes = 0, last = 0;
  for (const Integer<N>& x : f.c) {
    const int sign = x.sign();
    changes += sign * last < 0 ? 1 : 0;
    if (sign != 0) last = sign;
  }
  return changes;
}

/// A guess at the only root, by Newton's method between bounds.
template <int N>
COLLIDED_HD double root_guess(const Cubic<N>& f, int left_sign) {
  double c[4], low = 0, high = 1, t = 0.5;
  for (int i = 0; i < 4; ++i) c[i] = left_sign * to_double(f.c[i]);
  for (int i = 0; i < 32; ++i) {
    const double s = 1 - t;
    const double value = ((c[3] * t + c[2] * s) * t + c[1] * s * s) * t + c[0] * s * s * s;
    const double slope = 3 * (c[3] * t * t - c[0] * s * s) + c[1] * s * (s - 2 * t) + c[2] * t * (2 * s - t);
    (value > 0 ? low : high) = t;
    double next = t - value / slope;
    if (!(next > low && next < high)) next = (low + high) / 2;
    if (magnitude(next - t) < 0x1p-54) break;
    t = next;
  }
  return t;
}

/// The root of a cubic whose signs change once, rounded down to a multiple of 2^-60. Bounds close in on it from both
/// sides: first those around a guess, then by the secant and its neighbour, or half the way.
template <int N>
class RootSearch {
 public:
  /// `left_sign`: of f between 0 and the root.
  COLLIDED_HD RootSearch(const Cubic<N>& f, int left_sign) : f_(f), left_sign_(left_sign) {}

  COLLIDED_HD uint64_t run() {
    const uint64_t guess = static_cast<uint64_t>(root_guess(f_, left_sign_) * 0x1p60);
    for (uint64_t width = 256; width < kOne && high_ - low_ > 2 * width; width *= 256) {
      try_at(guess > width ? guess - width : 0);
      try_at(guess + width);
    }
    while (high_ - low_ > 1) {
      const uint64_t k = secant();
      try_at(k);
      try_at(k == low_ ? k + 1 : k - 1);
      try_at(low_ + (high_ - low_) / 2);
    }
    return low_;
  }

 private:
  /// Takes k for a bound, if it is between them.
  COLLIDED_HD void try_at(uint64_t k) {
    if (k <= low_ || k >= high_) return;
    const auto value = f_.at(k);
    const int sign = left_sign_ * value.sign();
    if (sign >= 0) low_ = k, at_low_ = magnitude(to_double(value));
    if (sign <= 0) high_ = sign < 0 ? k : k + 1, at_high_ = magnitude(to_double(value));
  }
  COLLIDED_HD uint64_t secant() const {
    const double share = at_low_ / (at_low_ + at_high_);
    const double steps = share * static_cast<double>(high_ - low_);
    return low_ + (steps >= 1 ? static_cast<uint64_t>(steps) : 1);
  }

  const Cubic<N>& f_;
  const int left_sign_;
  uint64_t low_ = 0, high_ = kOne;
  double at_low_ = 0, at_high_ = 0;
};

/// k / 2^60 as a double, rounded down.
COLLIDED_HD inline double time_of(uint64_t k) {
  int dropped = 0;
  while ((k >> dropped >> 53) != 0) ++dropped;
  return static_cast<double>(k >> dropped << dropped) * 0x1p-60;
}

}  // namespace collided::exact::fixed
