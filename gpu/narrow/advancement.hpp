#pragma once
// Certified separating-axis advancement: the step is covered from t = 0 on by intervals on which one direction, fixed
// or turning, keeps the features apart (separation.hpp). [0, t) is certified free at every moment, so that a miss is
// a miss and the time that is reported is never late, whatever the directions were; good directions only save
// iterations.

#include "gpu/narrow/separation.hpp"

namespace collided {

/// Iterations after which a query is reported as a contact at the time that was reached (kFlagCapped).
constexpr int kMaxAdvances = 64;

template <class Work>
struct Tolerance {
  Work thickness;  ///< scaled, rounded up
  Work delta;      ///< scaled
};

template <class Work>
struct Advance {
  bool hit;
  Work t;  ///< hit: lower bound of the first time of contact
  bool capped;
};

/// How the features face each other at one time.
template <class Work, int N>
struct Facing {
  Direction<Work> closest;  ///< between the closest points
  Direction<Work> normal;   ///< of the triangle, or of both edges
  Work gap, speed;          ///< between the closest points, and how fast it grows

  COLLIDED_HD Facing(const Differences<Work, N>& d, Work t) {
    Vec3<Work> x[N];
    for (int k = 0; k < N; ++k) x[k] = d.at(k, t);
    const Closest<Work> points = closest_points(x);
    const Vec3<Work> vector = between_points(x, points.w0, points.w1);
    closest = direction_of(vector);
    gap = std::sqrt(dot(vector, vector));
    const Vec3<Work> velocity =
        between_points(d.end, points.w0, points.w1) - between_points(d.start, points.w0, points.w1);
    speed = closest.length > 0 ? dot(closest.n, velocity) / closest.length : Work(0);
    normal = direction_of(common_normal(x));
    Work side = 0;
    for (int k = 0; k < N; ++k) side = side + dot(normal.n, x[k]);
    if (side < 0) normal.n = Work(-1) * normal.n;
  }
};

/// Most of the way to where the closest points meet at their present speed; `last` if they do not before it.
template <class Work, int N>
COLLIDED_HD Work time_ahead(const Facing<Work, N>& now, Work t, Work thickness, Work share, Work last) {
  if (!(now.speed < 0)) return last;
  const Work ahead = t + share * ((now.gap - thickness) / -now.speed);
  return ahead < last ? ahead : last;
}

/// Looks for contact in [0, last]; contact after `last` counts as a miss.
template <class Work, int N>
COLLIDED_HD Advance<Work> advance(const Differences<Work, N>& d, const Tolerance<Work>& tolerance, Work last) {
  constexpr Work kShare = Work(0.9375);
  Work t = 0, share = kShare;
  for (int i = 0; i < kMaxAdvances; ++i) {
    const Facing<Work, N> now(d, t);
    const Reach<Work> by_closest = reach_along(d, now.closest, t, tolerance.thickness);
    if (by_closest.until > last) return {false, t, false};
    const Reach<Work> by_normal = reach_along(d, now.normal, t, tolerance.thickness);
    const bool normal_is_better = by_normal.until > by_closest.until;
    const Reach<Work> reach = normal_is_better ? by_normal : by_closest;
    if (reach.until > last) return {false, t, false};
    if (!(reach.until > t) || !(reach.separation > tolerance.delta)) return {true, t, false};
    Work next = reach.until;
    // Features that turn need many fixed directions, but few turning ones.
    const Work ahead = i > 0 ? time_ahead(now, t, tolerance.thickness, share, last) : next;
    if (ahead > next || (i > 0 && ahead == last)) {
      const Facing<Work, N> then(d, ahead);
      const bool apart = normal_is_better
                             ? apart_while_turning(d, now.normal, then.normal, t, ahead, tolerance.thickness)
                             : apart_while_turning(d, now.closest, then.closest, t, ahead, tolerance.thickness);
      if (apart && ahead == last) return {false, t, false};
      if (apart) next = ahead;
      share = apart ? kShare : share / 4;
    }
    t = next;
  }
  return {true, t, true};
}

}  // namespace collided
