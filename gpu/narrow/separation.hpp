#pragma once
// Certified separation of two features that move linearly.
//
// For a fixed direction n, n . (x_i(t) - y_j(t)) is linear in t. If it is above 0 (above thickness * |n|) for all
// pairs of vertices on [t, h], so are all pairs of points of the two convex features: they are apart on [t, h], no
// matter where n came from. Only the numbers below need bounds; n may be found with any accuracy.
//
// Bounds, u = Precision::kUnit, D a difference within 2u of the truth (relative, per component), g = fl(n . D),
// s = fl(|n| . |D|):
// - g is within 5u |n| . |D| (1 + O(u)) of the truth: 2u of D, three for product and sums; s is low by at most as much
//   (relative), so 8u s covers it. Underflow adds less than kTiny, for |n| and D are at most 2.
// - fl(fl(g - offset) - error) and the last subtraction take three roundings: 4u of the result covers them, and what
//   they take of `error` lies in the slack of 8u s.
// - A chord of two lower bounds is a lower bound between them. (1 - t) a + t b is off by at most 3u ((1 - t)|a| +
// t|b|).

#include "gpu/narrow/differences.hpp"

namespace collided {

/// A direction to try; components below 2.
template <class Work>
struct Direction {
  Vec3<Work> n;
  Work length;  ///< 0: no direction
};

template <class Work>
COLLIDED_HD Direction<Work> direction_of(const Vec3<Work>& v) {
  const Work m = largest_component(v);
  if (!(m > 0)) return {v, 0};
  const Vec3<Work> n = unit_scale(m) * v;
  return {n, std::sqrt(dot(n, n))};
}

/// How far from t on a direction keeps the features apart.
template <class Work>
struct Reach {
  Work until;       ///< apart on [t, until), to the end of the step if it is kBeyond; t or less: not certified at t
  Work separation;  ///< lower estimate of how far apart they are at t, beyond the thickness; scaled

  static constexpr Work kBeyond = 2;
};

/// Lower bound of n . D - offset.
template <class Work>
COLLIDED_HD Work lower_bound_along(const Vec3<Work>& n, const Vec3<Work>& d, Work offset) {
  constexpr Work u = Precision<Work>::kUnit;
  const Work g = dot(n, d);
  const Work s = magnitude(n.x * d.x) + magnitude(n.y * d.y) + magnitude(n.z * d.z);
  const Work a = (g - offset) - (8 * u * s + 4 * u * offset + Precision<Work>::kTiny);
  return a - 4 * u * magnitude(a);
}

/// Lower bound at t of what has lower bounds a0 at 0 and a1 at 1 and is linear between.
template <class Work>
COLLIDED_HD Work lower_bound_at(Work a0, Work a1, Work t) {
  const Work from = (1 - t) * a0, to = t * a1;
  return (from + to) - 4 * Precision<Work>::kUnit * (magnitude(from) + magnitude(to));
}

/// thickness * |n|, rounded up.
template <class Work>
COLLIDED_HD Work offset_along(const Direction<Work>& direction, Work thickness) {
  return thickness * (direction.length * (1 + 16 * Precision<Work>::kUnit));
}

/// Whether a direction keeps the features apart over the whole step.
template <class Work, int N>
COLLIDED_HD bool apart_all_along(const Differences<Work, N>& d, const Direction<Work>& direction, Work thickness) {
  const Work offset = offset_along(direction, thickness);
  bool apart = direction.length > 0;
  for (int k = 0; k < N; ++k)
    apart = apart & (lower_bound_along(direction.n, d.start[k], offset) > 0) &
            (lower_bound_along(direction.n, d.end[k], offset) > 0);
  return apart;
}

template <class Work, int N>
COLLIDED_HD Reach<Work> reach_along(const Differences<Work, N>& d, const Direction<Work>& direction, Work t,
                                    Work thickness) {
  constexpr Work u = Precision<Work>::kUnit;
  Reach<Work> reach{Reach<Work>::kBeyond, Reach<Work>::kBeyond};
  if (direction.length == 0) return {Work(-1), Work(0)};
  const Work offset = offset_along(direction, thickness);
  for (int k = 0; k < N; ++k) {
    const Work a0 = lower_bound_along(direction.n, d.start[k], offset);
    const Work a1 = lower_bound_along(direction.n, d.end[k], offset);
    const Work now = lower_bound_at(a0, a1, t);
    if (!(now > 0)) return {Work(-1), Work(0)};
    reach.separation = smaller(reach.separation, now);
    if (a1 > 0) continue;
    const Work root = a0 / (a0 - a1);
    reach.until = smaller(reach.until, root - 8 * u * root);
  }
  reach.separation = reach.separation / direction.length;
  return reach;
}

/// Whether a direction that turns keeps the features apart on [t, h]: from `from` at t to `to` at h, linearly.
/// With s = (time - t) / (h - t) and n = (1 - s) from + s to, n . D - thickness |n| is at least
/// (1 - s) (from . D - thickness |from|) + s (to . D - thickness |to|), a quadratic in s: its Bernstein coefficients
/// are above 0 if its lower bounds below are.
template <class Work, int N>
COLLIDED_HD bool apart_while_turning(const Differences<Work, N>& d, const Direction<Work>& from,
                                     const Direction<Work>& to, Work t, Work h, Work thickness) {
  if (from.length == 0 || to.length == 0) return false;
  const Work from_offset = offset_along(from, thickness), to_offset = offset_along(to, thickness);
  for (int k = 0; k < N; ++k) {
    const Work a0 = lower_bound_along(from.n, d.start[k], from_offset);
    const Work a1 = lower_bound_along(from.n, d.end[k], from_offset);
    const Work b0 = lower_bound_along(to.n, d.start[k], to_offset);
    const Work b1 = lower_bound_along(to.n, d.end[k], to_offset);
    const Work middle = lower_bound_at(a0, a1, h) + lower_bound_at(b0, b1, t);
    if (!(lower_bound_at(a0, a1, t) > 0 && middle > 0 && lower_bound_at(b0, b1, h) > 0)) return false;
  }
  return true;
}

}  // namespace collided
