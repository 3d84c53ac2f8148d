#pragma once
// Whether features meet at a time at which their volume vanishes, between 0 and 1.
//
// The time is in [k, k + 1] / 2^60. A weight (weights.hpp) that double precision cannot tell from 0 may be 0. Then
// P x Q = 0, for in one plane it is parallel to the normal: the common point is on the line of that side. Components of
// P x Q, or of P, or of Q, that are multiples of each other vanish together, so that a change of sign in the interval
// proves that they do; the volume vanishes with P x Q, and where it has one root in the interval this is the time.

#include "gpu/exact/fixed/root.hpp"
#include "gpu/exact/fixed/weights.hpp"

namespace collided::exact::fixed {

/// Whether vectors that are one form's values at two times show that it vanishes between them, its components being
/// multiples of each other.
template <int N>
COLLIDED_HD bool vanishes_between(const Vec3<Integer<N>>& low, const Vec3<Integer<N>>& high) {
  return is_zero(low) != is_zero(high) || low.x.sign() * high.x.sign() < 0 || low.y.sign() * high.y.sign() < 0 ||
         low.z.sign() * high.z.sign() < 0;
}

template <ContactKind kind, int W>
class Crossing {
 public:
  /// `is_alone`: as for_each_root has it.
  COLLIDED_HD Crossing(const Differences<kind, W>& features, uint64_t k, bool is_alone)
      : d_(features.d), k_(k), is_alone_(is_alone) {}

  COLLIDED_HD Look look() const {
    Nearby nearby;
    Vec3<double> d[Differences<kind, W>::kCount];
    for (int i = 0; i < Differences<kind, W>::kCount; ++i) d[i] = nearby.see(d_[i], k_);
    const Weights<kind> weights(d, nearby.largest, nearby.change);
    bool has_normal = false;
    for (int i = 0; i < weights.kCount; ++i) {
      if (weights.is_negative(i)) return Look::kGoOn;
      has_normal = has_normal || weights.is_positive(i);
    }
    if (!has_normal) return Look::kOpen;
    for (int i = 0; i < weights.kCount; ++i)
      if (!weights.is_positive(i) && !vanishes(Sides<kind>::at(i))) return Look::kOpen;
    return Look::kFound;
  }

 private:
  COLLIDED_HD bool vanishes(const Side& side) const {
    return is_alone_ && (vanishes(d_[side.p]) || vanishes(d_[side.q]) || product_vanishes(d_[side.p], d_[side.q]));
  }
  COLLIDED_HD bool vanishes(const Moving<W>& a) const {
    return is_zero(wide_cross(a.p[0], a.p[1])) && vanishes_between(a.at(k_), a.at(k_ + 1));
  }
  COLLIDED_HD bool product_vanishes(const Moving<W>& p, const Moving<W>& q) const {
    const MovingProduct<W> pq(p, q);
    return is_zero(wide_cross(pq.c[0], pq.c[1])) && is_zero(wide_cross(pq.c[0], pq.c[2])) &&
           is_zero(wide_cross(pq.c[1], pq.c[2])) &&
           vanishes_between(wide_cross(p.at(k_), q.at(k_)), wide_cross(p.at(k_ + 1), q.at(k_ + 1)));
  }

  const Moving<W>* d_;
  uint64_t k_;
  bool is_alone_;
};

}  // namespace collided::exact::fixed
