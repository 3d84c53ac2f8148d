#pragma once
// The roots of a cubic in (0, 1), one after the other.

#include "gpu/exact/fixed/motion.hpp"

namespace collided::exact::fixed {

/// c[0] s^3 + c[1] s^2 t + c[2] s t^2 + c[3] t^3.
template <int N>
struct Cubic {
  Integer<N> c[4];

  /// Times 2^180, at k / 2^60.
  COLLIDED_HD Integer<N + 3> at(uint64_t k) const {
    const Time time(k);
    const auto ss = time.s * time.s;
    const auto high = (c[3] * time.t + c[2] * time.s) * time.t + c[1] * ss;
    return high * time.t + c[0] * (ss * time.s);
  }
  /// The same polynomial in the local parameter of [begin, end] / 2^60, times 2^180.
  COLLIDED_HD Cubic<N + 3> on(uint64_t begin, uint64_t end) const {
    return {{at(begin), inner(Time(begin), Time(end)), inner(Time(end), Time(begin)), at(end)}};
  }
  /// Changes of sign along the coefficients, zeros left out: the number of roots in (0, 1), or an even number more.
  COLLIDED_HD int sign_changes() const {
    int changes = 0, last = 0;
    for (const Integer<N>& x : c) {
      const int sign = x.sign();
      changes += sign * last < 0 ? 1 : 0;
      if (sign != 0) last = sign;
    }
    return changes;
  }
  /// That of f just right of 0; 0 if f vanishes.
  COLLIDED_HD int first_sign() const {
    for (const Integer<N>& x : c)
      if (const int sign = x.sign()) return sign;
    return 0;
  }

 private:
  /// The coefficient that takes two factors of three from one end of an interval, and one from the other.
  COLLIDED_HD Integer<N + 3> inner(const Time& twice, const Time& once) const {
    const auto ss = twice.s * twice.s, st = twice.s * twice.t, tt = twice.t * twice.t;
    const auto at_first = ss * once.s, at_last = tt * once.t;
    return c[0] * (at_first + at_first + at_first) + c[1] * (st * once.s + st * once.s + ss * once.t) +
           c[2] * (st * once.t + st * once.t + tt * once.s) + c[3] * (at_last + at_last + at_last);
  }
};

/// The interval [part, part + 1] / 2^depth.
struct Part {
  uint64_t part = 0;
  int depth = 0;

  COLLIDED_HD uint64_t begin() const { return part << (kTimeBits - depth); }
  COLLIDED_HD uint64_t end() const { return (part + 1) << (kTimeBits - depth); }
  COLLIDED_HD Part left_half() const { return {2 * part, depth + 1}; }
  /// The largest one that begins where this one ends; depth 0: there is none.
  COLLIDED_HD Part next() const {
    Part p = *this;
    while (p.depth > 0 && (p.part & 1) != 0) p = {p.part / 2, p.depth - 1};
    return p.depth == 0 ? p : Part{p.part + 1, p.depth};
  }
};

/// The signs of f's coefficients in the local parameter of a part of [0, 1].
template <int N>
class PartSigns {
 public:
  static constexpr int kMaxDepth = 20;  // products of three times are below 2^62: one limb

  COLLIDED_HD PartSigns(const Cubic<N>& f, const Part& on) {
    const int64_t t0 = static_cast<int64_t>(on.part), t1 = t0 + 1, s1 = (int64_t{1} << on.depth) - t1, s0 = s1 + 1;
    f_.c[0] = combined(f, s0 * s0 * s0, s0 * s0 * t0, s0 * t0 * t0, t0 * t0 * t0);
    f_.c[1] = inner(f, s0, t0, s1, t1);
    f_.c[2] = inner(f, s1, t1, s0, t0);
    f_.c[3] = combined(f, s1 * s1 * s1, s1 * s1 * t1, s1 * t1 * t1, t1 * t1 * t1);
  }
  COLLIDED_HD int changes() const { return f_.sign_changes(); }
  COLLIDED_HD int first() const { return f_.first_sign(); }
  COLLIDED_HD bool is_zero_at_begin() const { return f_.c[0].is_zero(); }
  COLLIDED_HD bool is_zero_at_end() const { return f_.c[3].is_zero(); }

 private:
  COLLIDED_HD static Integer<N + 1> combined(const Cubic<N>& f, int64_t a, int64_t b, int64_t c, int64_t d) {
    return f.c[0] * Integer<1>::of(a) + f.c[1] * Integer<1>::of(b) + f.c[2] * Integer<1>::of(c) +
           f.c[3] * Integer<1>::of(d);
  }
  /// As Cubic::inner.
  COLLIDED_HD static Integer<N + 1> inner(const Cubic<N>& f, int64_t s, int64_t t, int64_t s1, int64_t t1) {
    return combined(f, 3 * s * s * s1, 2 * s * t * s1 + s * s * t1, 2 * s * t * t1 + t * t * s1, 3 * t * t * t1);
  }

  Cubic<N + 1> f_;
};

/// Where the only root of f in an interval is, rounded down to a multiple of 2^-60. Bounds close in on it from both
/// sides: first those around a guess, then by the secant and its neighbour, or half the way.
template <int N>
class RootSearch {
 public:
  /// `sign`: of f between the interval's begin and the root.
  COLLIDED_HD RootSearch(const Cubic<N>& f, const Part& on, int sign)
      : f_(f), sign_(sign), low_(on.begin()), high_(on.end()) {}

  COLLIDED_HD uint64_t run() {
    const uint64_t guess = static_cast<uint64_t>(guessed() * 0x1p60);
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
  /// By Newton's method between bounds.
  COLLIDED_HD double guessed() const {
    double c[4], low = static_cast<double>(low_) * 0x1p-60, high = static_cast<double>(high_) * 0x1p-60;
    for (int i = 0; i < 4; ++i) c[i] = sign_ * to_double(f_.c[i]);
    double t = (low + high) / 2;
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
  /// Takes k for a bound, if it is between them.
  COLLIDED_HD void try_at(uint64_t k) {
    if (k <= low_ || k >= high_) return;
    const auto value = f_.at(k);
    const int sign = sign_ * value.sign();
    if (sign >= 0) low_ = k, at_low_ = magnitude(to_double(value));
    if (sign <= 0) high_ = sign < 0 ? k : k + 1, at_high_ = magnitude(to_double(value));
  }
  COLLIDED_HD uint64_t secant() const {
    const double share = at_low_ / (at_low_ + at_high_);
    const double steps = share * static_cast<double>(high_ - low_);
    return low_ + (steps >= 1 ? static_cast<uint64_t>(steps) : 1);
  }

  const Cubic<N>& f_;
  const int sign_;
  uint64_t low_, high_;
  double at_low_ = 0, at_high_ = 0;
};

/// What may be known of a root before the next one is looked for.
enum class Look : uint8_t { kGoOn, kFound, kOpen };

/// look(k, is_alone) for the roots of f in (0, 1) in their order, until it does not say kGoOn; each is in [k, k + 1) /
/// 2^60. `is_alone`: f has no other root there, k + 1 included. kOpen, too, where halving does not part the roots.
template <int N, class Use>
COLLIDED_HD Look for_each_root(const Cubic<N>& f, const Use& look) {
  Part on;
  do {
    const PartSigns<N> signs(f, on);
    const int changes = signs.changes();
    if (changes > 1) {
      if (on.depth == PartSigns<N>::kMaxDepth) return Look::kOpen;
      on = on.left_half();
      continue;
    }
    if (changes == 1) {
      const uint64_t k = RootSearch(f, on, signs.first()).run();
      const bool is_alone =
          !(signs.is_zero_at_begin() && k == on.begin()) && !(signs.is_zero_at_end() && k + 1 == on.end());
      if (const Look found = look(k, is_alone); found != Look::kGoOn) return found;
    }
    if (signs.is_zero_at_end() && on.end() != kOne)
      if (const Look found = look(on.end(), false); found != Look::kGoOn) return found;
    on = on.next();
  } while (on.depth != 0);
  return Look::kGoOn;
}

}  // namespace collided::exact::fixed
