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
  const Mask<Work> is_one = m > 0;
  if (!any(is_one)) return {v, 0};
  const Vec3<Work> n = select(is_one, unit_scale(m) * v, v);
  return {n, select(is_one, square_root(dot(n, n)), Work(0))};
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
  constexpr auto u = Precision<Work>::kUnit;
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
COLLIDED_HD Mask<Work> apart_all_along(const Differences<Work, N>& d, const Direction<Work>& direction,
                                       Work thickness) {
  const Work offset = offset_along(direction, thickness);
  Mask<Work> apart = direction.length > 0;
  for (int k = 0; k < N; ++k)
    apart = apart & (lower_bound_along(direction.n, d.start[k], offset) > 0) &
            (lower_bound_along(direction.n, d.end[k], offset) > 0);
  return apart;
}

/// Lower bounds, for each difference, of how far a direction keeps it from the thickness, at t = 0 and at t = 1, and
/// the least of them at the time that the direction was made for.
template <class Work, int N>
struct Along {
  Work length;  ///< of the direction
  Work least;   ///< above 0: apart at its time; never so without a direction, nor where a thickness is not a number
  Work start[N], end[N];

  COLLIDED_HD Mask<Work> is_apart() const { return least > 0; }
  /// From its own time on.
  COLLIDED_HD Reach<Work> reach() const {
    const Mask<Work> apart = is_apart();
    if (!any(apart)) return {Work(-1), Work(0)};
    Work until = Reach<Work>::kBeyond;
    for (int k = 0; k < N; ++k)
      until = replace_where(!(end[k] > 0), until, [&] { return min(until, until_touching(k)); });
    return {select(apart, until, Work(-1)), select(apart, least / length, Work(0))};
  }

 private:
  /// The k-th difference, which is not beyond the thickness at t = 1.
  COLLIDED_HD Work until_touching(int k) const {
    const Work root = start[k] / (start[k] - end[k]);
    return root - 8 * Precision<Work>::kUnit * root;
  }
};

/// A distance that features keep, at t = 0 and at t = 1, and linearly between: the bounds below are linear in t, or
/// where a direction turns, chords of such bounds; so they hold for it as they do for one distance.
template <class Work>
struct Thickness {
  Work start, end;  ///< scaled, rounded up; start <= end
};

/// `t`: the time that the direction was made for.
template <class Work, int N>
COLLIDED_HD Along<Work, N> along(const Differences<Work, N>& d, const Direction<Work>& direction,
                                 const Thickness<Work>& thickness, Work t) {
  Along<Work, N> out;
  out.length = direction.length;
  const Work at_start = offset_along(direction, thickness.start), at_end = offset_along(direction, thickness.end);
  Mask<Work> apart = direction.length > 0;
  out.least = Reach<Work>::kBeyond;
  for (int k = 0; k < N; ++k) {
    out.start[k] = lower_bound_along(direction.n, d.start[k], at_start);
    out.end[k] = lower_bound_along(direction.n, d.end[k], at_end);
    const Work now = lower_bound_at(out.start[k], out.end[k], t);
    apart = apart & (now > 0);
    out.least = min(out.least, now);
  }
  out.least = select(apart, out.least, Work(-1));
  return out;
}

/// Whether a direction that turns keeps the features apart on [t, h]: from `from`, made for t, to `to`, made for h,
/// linearly. With s = (time - t) / (h - t) and n = (1 - s) from + s to, n . D - thickness |n| is at least
/// (1 - s) (from . D - thickness |from|) + s (to . D - thickness |to|), a quadratic in s: its Bernstein coefficients
/// are above 0 if its lower bounds below are.
template <class Work, int N>
COLLIDED_HD Mask<Work> apart_while_turning(const Along<Work, N>& from, const Along<Work, N>& to, Work t, Work h) {
  Mask<Work> apart = from.is_apart() & to.is_apart();
  for (int k = 0; k < N; ++k) {
    const Work middle = lower_bound_at(from.start[k], from.end[k], h) + lower_bound_at(to.start[k], to.end[k], t);
    apart = apart & (middle > 0);
  }
  return apart;
}

}  // namespace collided
