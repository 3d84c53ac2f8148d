#pragma once
// Certified separating-axis advancement: the step is covered from t = 0 on by intervals on which one direction, fixed
// or turning, keeps the features apart (separation.hpp). [0, t) is certified free at every moment, so that a miss is
// a miss and the time that is reported is never late, whatever the directions were; good directions only save looks.

#include "gpu/narrow/pace.hpp"
#include "gpu/narrow/separation.hpp"

namespace collided {

/// Looks after the first one, after which a query is reported as a contact at the time that was reached (kFlagCapped).
constexpr int kMostLooks = 64;

template <class Work>
struct Tolerance {
  Work thickness;  ///< scaled, rounded up
  Work delta;      ///< scaled
};

/// How far a query has come: apart on [0, t) for certain, with the pace that was right so far.
struct Progress {
  float t = 0;
  Pace pace;
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
  Work gap, speed;  ///< as in Facing
  Along<Work, N> closest, normal;

  COLLIDED_HD static View at(const Differences<Work, N>& d, Work t, Work thickness) {
    const Facing<Work, N> facing(d, t);
    return {facing.gap, facing.speed, along(d, facing.closest, thickness), along(d, facing.normal, thickness)};
  }
  /// Whether a direction that turns from what it is here, at t, to what it is there, at h, keeps the features apart.
  COLLIDED_HD bool is_apart_until(const View& then, Work t, Work h) const {
    return apart_while_turning(normal, then.normal, t, h) || apart_while_turning(closest, then.closest, t, h);
  }
};

/// Looks for contact of two features in [0, 1], a look at a time, from where an earlier search left off.
template <class Work, int N>
class Advancement {
 public:
  Differences<Work, N> d;  ///< to be loaded before begin()

  COLLIDED_HD void begin(const Tolerance<Work>& tolerance, const Progress& from, int most_looks) {
    tolerance_ = tolerance;
    pace_ = from.pace;
    t_ = next_ = from.t;
    looks_ = 0;
    most_looks_ = most_looks;
    outcome_ = Outcome::kOpen;
  }
  COLLIDED_HD bool is_over() const { return outcome_ != Outcome::kOpen; }
  /// After the last look: whether they meet, as far as that is known.
  COLLIDED_HD bool is_hit() const { return outcome_ == Outcome::kContact || is_capped(); }
  COLLIDED_HD bool is_capped() const { return outcome_ == Outcome::kCapped; }
  /// Apart on [0, t) for certain.
  COLLIDED_HD Work time() const { return t_; }
  COLLIDED_HD const Pace& pace() const { return pace_; }
  COLLIDED_HD Work thickness() const { return tolerance_.thickness; }

  /// Looks at the features at the time that was chosen for it. A contact that is certain to be reported after `last`
  /// may count as a miss; `last` never changes the time of a hit, for what it is depends on the order of the queries.
  COLLIDED_HD void look(Work last) {
    const View<Work, N> then = View<Work, N>::at(d, next_, tolerance_.thickness);
    if (looks_++ == 0)
      now_ = then;
    else
      outcome_ = arrive(then);
    if (!is_over()) outcome_ = choose_next(last);
  }

 private:
  enum class Outcome : uint8_t { kOver, kOpen, kApart, kContact, kCapped };

  COLLIDED_HD Outcome arrive(const View<Work, N>& then) {
    const Work step = next_ - t_;
    if (turns_) {
      if (!now_.is_apart_until(then, t_, next_)) {
        pace_.fail(step);
        return Outcome::kOpen;
      }
      if (next_ == 1) return Outcome::kApart;
    }
    pace_.succeed(step, now_.gap, now_.speed, then.gap);
    now_ = then;
    t_ = next_;
    return Outcome::kOpen;
  }

  COLLIDED_HD Outcome choose_next(Work last) {
    if (t_ > last) return Outcome::kApart;
    const Reach<Work> by_closest = now_.closest.reach(t_), by_normal = now_.normal.reach(t_);
    const Reach<Work> reach{larger(by_closest.until, by_normal.until),
                            larger(by_closest.separation, by_normal.separation)};
    if (reach.until > 1) return Outcome::kApart;
    if (!(reach.until > t_) || !(reach.separation > tolerance_.delta)) return Outcome::kContact;
    if (reach.until > last) return Outcome::kApart;
    if (looks_ > most_looks_) return Outcome::kCapped;
    // Features that turn need many fixed directions, but few turning ones.
    const Work rounding = 32 * Precision<Work>::kUnit * d.extent;
    const Work ahead = pace_.ahead_of(t_, now_.gap - tolerance_.thickness, now_.speed, rounding);
    turns_ = ahead > reach.until;
    next_ = turns_ ? ahead : reach.until;
    return Outcome::kOpen;
  }

  Tolerance<Work> tolerance_;
  Pace pace_;
  Work t_, next_;
  View<Work, N> now_;
  int looks_, most_looks_;
  bool turns_;
  Outcome outcome_ = Outcome::kOver;
};

}  // namespace collided
