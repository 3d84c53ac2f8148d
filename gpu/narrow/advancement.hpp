#pragma once
// Certified separating-axis advancement: the step is covered from t = 0 on by intervals on which one direction, fixed
// or turning, keeps the features apart (separation.hpp). [0, t) is certified free at every moment, so that a miss is
// a miss and the time that is reported is never late, whatever the directions were; good directions only save
// iterations.

#include "gpu/narrow/pace.hpp"
#include "gpu/narrow/separation.hpp"

namespace collided {

/// Iterations after the first one, after which a query is reported as a contact at the time that was reached
/// (kFlagCapped).
constexpr int kMaxIterations = 64;

template <class Work>
struct Tolerance {
  Thickness<Work> thickness;
  Work delta;  ///< scaled
};

/// Tolerance in units of the query's extent where none is given: what a few more iterations cannot improve.
COLLIDED_HD inline float default_delta(float) { return 0x1p-20f; }
COLLIDED_HD inline double default_delta(double) { return 0x1p-48; }

/// How far a query has come: apart on [0, t) for certain, with the pace that was right so far.
struct Progress {
  float t = 0;
  Pace pace;
};

/// How the features face each other at one time: nearly, for it is only a guess at good directions.
template <class Work, int N>
struct ClosestFeatures {
  Vec3<Work> closest;  ///< between the closest points
  Vec3<Work> normal;   ///< of the triangle, or of both edges, to the first feature's side
  Mask<Work> inside;   ///< the closest points are inside the features, so that both are the same direction
  Work gap, speed;     ///< between the closest points, and how fast it grows

  COLLIDED_HD ClosestFeatures(const Differences<Work, N>& d, Work t) {
    Vec3<Work> x[N];
    differences_at(d, t, x);
    normal = common_normal(x);
    const Weights<Work> points = nearly_closest_points(x, normal);
    normal = replace_where(dot(normal, x[0]) < 0, normal, [&] { return Work(-1) * normal; });
    inside = points.inside;
    closest = between_points(x, points.w0, points.w1);
    gap = square_root(dot(closest, closest));
    const Vec3<Work> velocity =
        between_points(d.end, points.w0, points.w1) - between_points(d.start, points.w0, points.w1);
    speed = replace_where(gap > 0, Work(0), [&] { return dot(closest, velocity) / gap; });
  }
  /// Inside, the normal is the more precise one where the gap is small.
  COLLIDED_HD Direction<Work> best() const { return direction_of(select(inside, normal, closest)); }
  COLLIDED_HD Direction<Work> other() const { return direction_of(select(inside, closest, normal)); }
};

/// The features at one time, and how far a direction keeps them apart: the best one at hand, unless only the other one
/// does.
template <class Work, int N>
struct View {
  Work gap, speed;  ///< as in ClosestFeatures
  Along<Work, N> directed;

  COLLIDED_HD static View at(const Differences<Work, N>& d, Work t, const Thickness<Work>& thickness) {
    const ClosestFeatures<Work, N> closest_features(d, t);
    View view{closest_features.gap, closest_features.speed, along(d, closest_features.best(), thickness, t)};
    const Mask<Work> apart = view.directed.is_apart();
    if (!all(apart)) view.directed = select(apart, view.directed, along(d, closest_features.other(), thickness, t));
    return view;
  }
};

/// Searches for contact of two features in [0, 1], an iteration at a time, from where an earlier search left off.
template <class Work, int N>
class Advancement {
 public:
  Differences<Work, N> d;  ///< to be loaded before begin()

  COLLIDED_HD void begin(const Tolerance<Work>& tolerance, const Progress& from, int max_iterations) {
    tolerance_ = tolerance;
    pace_ = from.pace;
    t_ = next_ = from.t;
    iterations_ = 0;
    max_iterations_ = max_iterations;
    outcome_ = Outcome::kOpen;
  }
  COLLIDED_HD bool is_over() const { return outcome_ != Outcome::kOpen; }
  /// After the last iteration: whether they meet, as far as that is known.
  COLLIDED_HD bool is_hit() const { return outcome_ == Outcome::kContact || is_capped(); }
  COLLIDED_HD bool is_capped() const { return outcome_ == Outcome::kCapped; }
  /// Apart on [0, t) for certain.
  COLLIDED_HD Work time() const { return t_; }
  COLLIDED_HD const Pace& pace() const { return pace_; }
  COLLIDED_HD const Tolerance<Work>& tolerance() const { return tolerance_; }
  /// At that time, between points of the features that are nearly the closest: the distance, or more.
  COLLIDED_HD Work gap() const { return now_.gap; }

  /// Looks at the features at the time that was chosen for it. A contact that is certain to be reported after `last`
  /// may count as a miss; `last` never changes the time of a hit, for what it is depends on the order of the queries.
  COLLIDED_HD void iterate(Work last) {
    const View<Work, N> then = View<Work, N>::at(d, next_, tolerance_.thickness);
    if (iterations_++ == 0)
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
      if (!apart_while_turning(now_.directed, then.directed, t_, next_)) {
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
    const Reach<Work> reach = now_.directed.reach();
    if (reach.until > 1) return Outcome::kApart;
    if (!(reach.until > t_) || !(reach.separation > tolerance_.delta)) return Outcome::kContact;
    if (reach.until > last) return Outcome::kApart;
    if (iterations_ > max_iterations_) return Outcome::kCapped;
    // Features that turn need many fixed directions, but few turning ones.
    const Work rounding = 32 * Precision<Work>::kUnit * d.extent;
    const Work ahead = pace_.ahead_of(t_, now_.gap - tolerance_.thickness.end, now_.speed, rounding);
    turns_ = ahead > reach.until;
    next_ = turns_ ? ahead : reach.until;
    return Outcome::kOpen;
  }

  Tolerance<Work> tolerance_;
  Pace pace_;
  Work t_, next_;
  View<Work, N> now_;
  int iterations_, max_iterations_;
  bool turns_;
  Outcome outcome_ = Outcome::kOver;
};

}  // namespace collided
