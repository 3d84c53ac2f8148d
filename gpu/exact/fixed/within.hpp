#pragma once
// Signs of determinants decide if features at rest are within a contact distance of each other, in the cases of
// exact/features.cpp. The bounds of differences.hpp hold for all sums.

#include "gpu/exact/fixed/differences.hpp"

namespace collided::exact::fixed {

/// At t = 0.
template <ContactKind kind, int W>
class Within {
 public:
  COLLIDED_HD Within(const Differences<kind, W>& features, const Integer<W>& limit)
      : d_(features.d), squared_(limit * limit) {}

  COLLIDED_HD bool run() const {
    for (int i = 0; i < Differences<kind, W>::kCount; ++i)
      if (is_within(wide_dot(at(i), at(i)), squared_)) return true;
    constexpr int kSides = Sides<kind>::kCount;
    Vec3<Integer<2 * W>> sides[kSides];
    for (int i = 0; i < kSides; ++i) {
      const Side side = Sides<kind>::at(i);
      sides[i] = wide_cross(at(side.p), at(side.q));
      if (is_near_segment(at(side.p), at(side.q), sides[i])) return true;
    }
    return are_planes_near(sides);
  }

 private:
  COLLIDED_HD const Vec3<Integer<W>>& at(int i) const { return d_[i].p[0]; }

  template <int N>
  COLLIDED_HD static bool is_within(const Integer<N>& squared_distance, const Integer<N>& limit) {
    return !(limit - squared_distance).is_negative();
  }
  /// The foot of the point is on the side p - q, which has a length, and is near enough.
  COLLIDED_HD bool is_near_segment(const Vec3<Integer<W>>& p, const Vec3<Integer<W>>& q,
                                   const Vec3<Integer<2 * W>>& pq) const {
    const Vec3<Integer<W>> e = p - q;
    return !is_zero(e) && wide_dot(p, e).sign() >= 0 && wide_dot(q, e).sign() <= 0 &&
           is_within(wide_dot(pq, pq), squared_ * wide_dot(e, e));
  }
  COLLIDED_HD bool are_planes_near(const Vec3<Integer<2 * W>>* sides) const {
    const Vec3<Integer<2 * W>> n = normal_of<kind>(sides);
    if (is_zero(n)) return false;
    for (int i = 0; i < Sides<kind>::kCount; ++i)
      if (wide_dot(sides[i], n).sign() < 0) return false;
    const Integer<3 * W> volume = wide_dot(at(0), wide_cross(at(1), at(2)));
    return is_within(volume * volume, squared_ * wide_dot(n, n));
  }

  const Moving<W>* d_;
  const Integer<2 * W> squared_;
};

}  // namespace collided::exact::fixed
