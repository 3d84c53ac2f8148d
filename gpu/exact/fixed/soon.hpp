#pragma once
// Features that meet for the first time soon after a time that is known, while their volume changes steadily: most
// contacts, once conservative advancement has come close. In numbers of twice double's precision, and many times as
// fast as the roots of integers.
//
// Lengths are scaled so that no component of the features' differences is above 1 in the step; D is what they change by
// at most. With u = 2^-53, and f the volume, A . (B x C):
// - f in double-double: differences within 32u^2, products of two within 91u^2 and their differences within 188u^2, f
//   within 1024u^2 = 2^-96,
// - f' in double: 18 products of three, all roundings together are below 256u D,
// - |f''| is at most 6 determinants, below 36 D^2.

#include "gpu/base/twofold.hpp"
#include "gpu/exact/fixed/weights.hpp"

namespace collided::exact::fixed {

template <ContactKind kind>
class SoonMeeting {
 public:
  COLLIDED_HD SoonMeeting(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4]) {
    set(start, from_);
    set(end, way_);
    double largest = 0;
    for (int i = 0; i < kCount; ++i)
      largest = max(largest, max(largest_component(rounded(from_[i])), largest_component(rounded(way_[i]))));
    is_ordinary_ = largest > kSmallest && largest < 1 / kSmallest;
    const double scale = is_ordinary_ ? 0.5 / power_of_two_in(largest) : 0;
    for (int i = 0; i < kCount; ++i) {
      from_[i] = scaled(from_[i], scale);
      way_[i] = scaled(way_[i], scale) - from_[i];
      change_ = max(change_, largest_component(rounded(way_[i])) * (1 + 0x1p-50));
    }
  }

  /// Whether f is known to have just one root from `from` until soon after it, and this one between k and k + 1, as
  /// multiples of 2^-60.
  COLLIDED_HD bool find_root(double from, uint64_t& k) const {
    if (!is_ordinary_) return false;
    const uint64_t first = static_cast<uint64_t>(from * 0x1p60);
    const double slope = slope_at(from), steepness = magnitude(slope);
    uint64_t last = k = first;
    for (int i = 0; i < kMostSteps && k >= first && k < kOne; ++i) {
      last = max(last, k);
      const double f = volume_at(k) * (slope > 0 ? -1 : 1);  // falls
      const double least = steepness - error_of_slope(static_cast<double>(last - first) * 0x1p-60);
      if (!(least > 0)) return false;
      if (f > kError && f < least * 0x1p-60 - kError) return true;
      const double steps = f / steepness * 0x1p60;
      if (!(magnitude(steps) < 0x1p60)) return false;
      k += static_cast<uint64_t>(static_cast<int64_t>(steps) - (steps < 0 ? 1 : 0));
    }
    return false;
  }

  /// Whether they meet at that root; false: perhaps.
  COLLIDED_HD bool meet_at(uint64_t k) const {
    Vec3<double> d[kCount];
    for (int i = 0; i < kCount; ++i) d[i] = rounded(at(i, time_at(k)));
    return Weights<kind>(d, 1, change_ * 0x1p-60).are_positive();
  }

 private:
  static constexpr int kCount = Differences<kind, 1>::kCount, kMostSteps = 6;
  static constexpr double kSmallest = 0x1p-300, kError = 0x1p-96;

  /// 2^n <= x < 2^(n + 1).
  COLLIDED_HD static double power_of_two_in(double x) {
    return detail::bit_copy<double>(detail::bit_copy<uint64_t>(x) & detail::Bits<double>::kInfinity);
  }
  COLLIDED_HD static void set(const Vec3<double> (&p)[4], Vec3<Twofold> (&d)[kCount]) {
    for (int i = 0; i < kCount; ++i)
      d[i] = kCount == 3 ? exact_difference(p[0], p[i + 1]) : exact_difference(p[i / 2], p[2 + i % 2]);
  }
  COLLIDED_HD Vec3<Twofold> at(int i, const Twofold& t) const { return from_[i] + t * way_[i]; }
  COLLIDED_HD static Twofold time_at(uint64_t k) {
    const double high = static_cast<double>(k);
    return scaled(Twofold{high, static_cast<double>(static_cast<int64_t>(k - static_cast<uint64_t>(high)))}, 0x1p-60);
  }
  COLLIDED_HD double volume_at(uint64_t k) const {
    const Twofold t = time_at(k);
    return triple(at(1, t), at(2, t), at(0, t)).high;
  }
  COLLIDED_HD double slope_at(double t) const {
    Vec3<double> d[3], way[3];
    for (int i = 0; i < 3; ++i) d[i] = rounded(at(i, {t, 0})), way[i] = rounded(way_[i]);
    return dot(way[0], cross(d[1], d[2])) + dot(d[0], cross(way[1], d[2]) + cross(d[1], way[2]));
  }
  /// Of any time that is no farther from where the slope was looked at, or by two units of time.
  COLLIDED_HD double error_of_slope(double later) const {
    return 256 * 0x1p-53 * change_ + 36 * change_ * change_ * (later + 0x1p-50);
  }

  Vec3<Twofold> from_[kCount], way_[kCount];  // where they are at t = 0, and what they change by
  double change_ = 0;
  bool is_ordinary_ = false;
};

}  // namespace collided::exact::fixed
