#pragma once
// Whether features meet at the one time between 0 and 1 at which they are in one plane.
//
// The volume has one root in the bracket [k, k + 1] / 2^60, and the weights of their common point (as in
// exact/features.cpp: cross products times the normal) are not negative there if they meet. In double precision, with
// differences of components at most L, exact but for 2^-51 of each, that change by at most V in the bracket, u = 2^-53:
// - a weight is at most 48 products of four, and all roundings together are below 2048u L^4,
// - it changes by at most 4 * 48 V L^3.
// A weight below that bound may be 0. Then P x Q = 0 at the root, for in one plane it is parallel to the normal: the
// common point is on the line of that side. What makes P x Q, or P, or Q, vanish at one time in all its components are
// components that are multiples of each other, so that a change of sign of one in the bracket proves it; wherever P x Q
// vanishes the volume does, and that has no other root there.

#include "gpu/exact/fixed/root.hpp"

namespace collided::exact::fixed {

/// A vector that moves, as coefficients of s^(n-1-j) t^j; at k / 2^60 but for a positive factor.
template <int N>
COLLIDED_HD Vec3<Integer<N + 1>> at_time(const Vec3<Integer<N>>& start, const Vec3<Integer<N>>& end, uint64_t k) {
  const Time time(k);
  return {start.x * time.s + end.x * time.t, start.y * time.s + end.y * time.t, start.z * time.s + end.z * time.t};
}

template <int N>
COLLIDED_HD Vec3<double> to_double(const Vec3<Integer<N>>& a) {
  return {to_double(a.x), to_double(a.y), to_double(a.z)};
}

/// Whether parallel vectors, the values of one form at two times, show that it vanishes between them.
template <int N>
COLLIDED_HD bool vanishes_between(const Vec3<Integer<N>>& low, const Vec3<Integer<N>>& high) {
  return (is_zero(low) != is_zero(high)) || low.x.sign() * high.x.sign() < 0 || low.y.sign() * high.y.sign() < 0 ||
         low.z.sign() * high.z.sign() < 0;
}

template <ContactKind kind, int W>
class Crossing {
 public:
  enum class Answer : uint8_t { kApart, kMeet, kOpen };

  /// `k`: the root is in [k, k + 1]. `is_only_root`: of the volume there, ends included.
  COLLIDED_HD Crossing(const Differences<W>& start, const Differences<W>& end, uint64_t k, bool is_only_root)
      : start_(start), end_(end), k_(k), is_only_root_(is_only_root) {}

  COLLIDED_HD Answer answer() const {
    constexpr int kCount = Sides<kind>::kCount;
    Vec3<double> d[4], sides[kCount];
    double largest = 0, change = 0;
    for (int i = 0; i < 4; ++i) {
      if (kind == ContactKind::kVertexTriangle && i == 3) continue;
      d[i] = to_double(at_time(start_.d[i], end_.d[i], k_));
      largest = max(largest, largest_component(d[i]));
      change = max(change, largest_component(to_double(end_.d[i] - start_.d[i])));
    }
    change *= 1 + 0x1p-50;
    largest += change;
    const double error = (2048 * 0x1p-53 * largest + 256 * change) * (largest * largest * largest);
    for (int i = 0; i < kCount; ++i) sides[i] = cross(d[Sides<kind>::at(i).p], d[Sides<kind>::at(i).q]);
    const Vec3<double> n = normal_of<kind>(sides);
    bool has_normal = false, may_vanish[kCount];
    for (int i = 0; i < kCount; ++i) {
      const double weight = dot(sides[i], n);
      if (weight < -error) return Answer::kApart;
      may_vanish[i] = !(weight > error);
      has_normal = has_normal || !may_vanish[i];
    }
    if (!has_normal) return Answer::kOpen;
    for (int i = 0; i < kCount; ++i)
      if (may_vanish[i] && !vanishes(Sides<kind>::at(i))) return Answer::kOpen;
    return Answer::kMeet;
  }

 private:
  COLLIDED_HD bool vanishes(const Side& side) const {
    return is_only_root_ && (vanishes(side.p) || vanishes(side.q) || product_vanishes(side));
  }
  COLLIDED_HD bool vanishes(int i) const {
    const Vec3<Integer<W>>&a = start_.d[i], &b = end_.d[i];
    return is_zero(wide_cross(a, b)) && vanishes_between(at_time(a, b, k_), at_time(a, b, k_ + 1));
  }
  COLLIDED_HD bool product_vanishes(const Side& side) const {
    const Vec3<Integer<W>>&p0 = start_.d[side.p], &p1 = end_.d[side.p], &q0 = start_.d[side.q], &q1 = end_.d[side.q];
    const auto c0 = wide_cross(p0, q0), c1 = wide_cross(p0, q1) + wide_cross(p1, q0), c2 = wide_cross(p1, q1);
    if (!is_zero(wide_cross(c0, c1)) || !is_zero(wide_cross(c0, c2)) || !is_zero(wide_cross(c1, c2))) return false;
    return vanishes_between(wide_cross(at_time(p0, p1, k_), at_time(q0, q1, k_)),
                            wide_cross(at_time(p0, p1, k_ + 1), at_time(q0, q1, k_ + 1)));
  }

  const Differences<W>&start_, &end_;
  const uint64_t k_;
  const bool is_only_root_;
};

}  // namespace collided::exact::fixed
