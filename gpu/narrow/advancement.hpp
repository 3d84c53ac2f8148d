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

/// How far a query has come: apart on [0, t) for certain, with the pace that was right so far.
struct Progress {
  float t = 0;
  float left = 1.0f / 16;  ///< Pace::left
};

template <class Work>
struct Advance {
  bool hit;
  Work t;  ///< hit: lower bound of the first time of contact
  bool capped;
  Work left = 0;  ///< Pace::left
};

/// How the features face each other at one time.
template <class Work, int N>
struct Facing {
  Direction<Work> closest;  ///< between the closest points
  Direction<Work> normal;   ///< of the triangle, or of both edges
  Work gap, speed;          ///< between the closest points, and how fast it grows

  COLLIDED_HD Facing(const Differences<Work, N>& d, Work t) {
    Vec3<Work> x[N];
    differences_at(d, t, x);
    const auto [points, vector, length] = gap_between(x);
    closest = direction_of(vector);
    gap = length;
    const Vec3<Work> velocity =
        between_points(d.end, points.w0, points.w1) - between_points(d.start, points.w0, points.w1);
    speed = closest.length > 0 ? dot(closest.n, velocity) / closest.length : Work(0);
    normal = direction_of(common_normal(x));
    Work side = 0;
    for (int k = 0; k < N; ++k) side = side + dot(normal.n, x[k]);
    if (side < 0) normal.n = Work(-1) * normal.n;
  }
};

/// The features at one time, and how far the directions at hand keep them apart.
template <class Work, int N>
struct View {
  Facing<Work, N> facing;
  Along<Work, N> closest, normal;

  COLLIDED_HD View(const Differences<Work, N>& d, Work t, Work thickness)
      : facing(d, t), closest(d, facing.closest, thickness), normal(d, facing.normal, thickness) {}
};

/// How far the next turning direction reaches. Newton's method on the gap, kept a little short of contact: the share of
/// the gap that is left is squared after each success, as the error of Newton's method is, and takes its root after
/// each failure.
template <class Work>
struct Pace {
  Work left;
  Work limit = 1;  ///< longest step that is worth a try

  /// A time after t at which the features should still be apart; 1 if they do not come closer.
  COLLIDED_HD Work ahead_of(Work t, Work gap, Work speed, Work least_gap) const {
    const Work most = smaller(Work(1), t + limit);
    if (!(speed < 0)) return most;
    return smaller(most, t + (gap - larger(left * gap, least_gap)) / -speed);
  }
  COLLIDED_HD void succeed() {
    constexpr Work kLeast = sizeof(Work) == 8 ? Work(1e-12) : Work(1e-5);
    left = larger(left * left, kLeast);
    limit = 4 * limit;
  }
  COLLIDED_HD void fail(Work step) {
    left = smaller(Work(1) / 4, std::sqrt(left));
    limit = step / 4;
  }
};

/// Looks for contact in [0, 1], from where an earlier look left off. A contact that is certain to be reported
/// after `last` may count as a miss; `last` never changes the time of a hit, for what it is depends on the order of the
/// queries.
template <class Work, int N>
COLLIDED_HD Advance<Work> advance(const Differences<Work, N>& d, const Tolerance<Work>& tolerance, Work last,
                                  const Progress& from, int iterations) {
  const Work rounding = 32 * Precision<Work>::kUnit * d.extent;
  Work t = from.t;
  Pace<Work> pace{from.left};
  View<Work, N> now(d, t, tolerance.thickness);
  for (int i = 0; i < iterations; ++i) {
    if (t > last) return {false, t, false};
    const Reach<Work> by_closest = now.closest.reach(t);
    if (by_closest.until > 1) return {false, t, false};
    const Reach<Work> by_normal = now.normal.reach(t);
    const Reach<Work> reach{larger(by_closest.until, by_normal.until),
                            larger(by_closest.separation, by_normal.separation)};
    if (reach.until > 1) return {false, t, false};
    if (!(reach.until > t) || !(reach.separation > tolerance.delta)) return {true, t, false, pace.left};
    if (reach.until > last) return {false, t, false};
    // Features that turn need many fixed directions, but few turning ones.
    const Work step = reach.until - t;
    pace.limit = larger(pace.limit, 2 * step);
    const Work ahead = pace.ahead_of(t, now.facing.gap - tolerance.thickness, now.facing.speed, rounding);
    const bool tries = ahead > reach.until;
    const Work next = tries ? ahead : reach.until;
    const View<Work, N> then(d, next, tolerance.thickness);
    if (!tries) {
      pace.succeed();
      now = then;
      t = next;
      continue;
    }
    const bool use_normal = by_normal.until - t > step / 2;  // it keeps its digits when the gap has lost them
    const bool apart = use_normal ? apart_while_turning(now.normal, then.normal, t, next)
                                  : apart_while_turning(now.closest, then.closest, t, next);
    if (apart && next == 1) return {false, t, false};
    apart ? pace.succeed() : pace.fail(next - t);
    t = apart ? next : reach.until;
    now = apart ? then : View<Work, N>(d, t, tolerance.thickness);
  }
  return {true, t, true, pace.left};
}

}  // namespace collided
