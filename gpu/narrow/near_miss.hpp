#pragma once
// Near misses: features that pass each other too closely for the directions of advancement.hpp.
//
// Those directions are vectors between closest points. Rounding turns such a vector by about u / gap, which moves the
// far ends of the features by u / gap along it: features that are closer than the square root of u cannot be told
// apart. Normals of faces and of crossing edges have no such error, but they do not separate features that move within
// one plane, nor features that slide past each other's borders. The directions below are as precise as normals. Each is
// exactly across what the features would otherwise move along: edges, the relative motion, or the plane of all of it.
// proto/ACCURACY.md states how sharp that makes CERTIFIED.

#include "gpu/exec/counted.hpp"
#include "gpu/narrow/advancement.hpp"

namespace collided {

namespace detail {

/// `v` without its part along `axis`, a vector of any length. The second pass removes what cancellation leaves of the
/// first one.
template <class Work>
COLLIDED_HD Vec3<Work> reject(const Vec3<Work>& v, const Vec3<Work>& axis) {
  const Work squared = dot(axis, axis);
  if (!(squared > 0)) return v;
  const Vec3<Work> once = v - (dot(v, axis) / squared) * axis;
  return once - (dot(once, axis) / squared) * axis;
}

/// A vector across both. The plain cross product of vectors that are almost parallel is off by u / sine; that of the
/// rejection is across both to within u.
template <class Work>
COLLIDED_HD Vec3<Work> across_both(const Vec3<Work>& v, const Vec3<Work>& w) {
  return cross(v, direction_of(reject(w, v)).n);
}

/// The edges of the features: those of the triangle, or both.
template <class Work>
COLLIDED_HD void edges_of(const Vec3<Work> (&x)[3], Vec3<Work> (&edges)[3]) {
  edges[0] = x[0] - x[1], edges[1] = x[0] - x[2], edges[2] = x[1] - x[2];
}
template <class Work>
COLLIDED_HD void edges_of(const Vec3<Work> (&x)[4], Vec3<Work> (&edges)[2]) {
  edges[0] = x[2] - x[0], edges[1] = x[0] - x[1];
}

}  // namespace detail

/// Directions that may separate the features at one time, in the same order at all times: the vector between the
/// closest points, its rejections from each edge and from the motion of these points, the common normal, and what is
/// across an edge and the motion, or across the normal and either.
template <class Work, int N>
class PreciseDirections {
  static constexpr uint32_t kEdges = N == 3 ? 3 : 2, kAxes = kEdges + 1;

 public:
  static constexpr uint32_t kCount = 2 + kAxes + kEdges + kAxes;

  COLLIDED_HD PreciseDirections(const Differences<Work, N>& d, Work t) {
    differences_at(d, t, x_);
    const Gap<Work> gap = gap_between(x_);
    const Vec3<Work> motion =
        between_points(d.end, gap.points.w0, gap.points.w1) - between_points(d.start, gap.points.w0, gap.points.w1);
    length_ = gap.length;
    speed_ = length_ > 0 ? dot(gap.vector, motion) / length_ : Work(0);
    gap_ = direction_of(gap.vector).n;
    detail::edges_of(x_, edges_);
    for (uint32_t k = 0; k < kEdges; ++k) axes_[k] = direction_of(edges_[k]).n;
    axes_[kEdges] = direction_of(motion).n;
    const Direction<Work> across = direction_of(detail::across_both(axes_[0], axes_[1]));
    normal_ = across.length > 0 ? (1 / across.length) * across.n : Vec3<Work>{0, 0, 0};
  }

  COLLIDED_HD Direction<Work> operator[](uint32_t k) const {
    if (k == 0) return direction_of(gap_);
    if (--k < kAxes) return direction_of(detail::reject(gap_, axes_[k]));
    k -= kAxes;
    if (k == 0) return facing(direction_of(normal_));
    if (--k < kEdges) return facing(direction_of(detail::across_both(axes_[k], axes_[kEdges])));
    k -= kEdges;
    if (k == kEdges) return facing(direction_of(cross(normal_, axes_[kEdges])));
    // In a plane this direction turns linearly, as the edge does. A scale that changed with time would spoil that.
    const Vec3<Work> v = Work(0.125) * cross(normal_, edges_[k]);
    // A square that may have underflowed says nothing of the length.
    const Work squared = dot(v, v);
    return facing({v, squared > Precision<Work>::kTiny / Precision<Work>::kUnit ? square_root(squared) : Work(0)});
  }
  /// Replaces the vector between the closest points.
  COLLIDED_HD void replace_gap(const Vec3<Work>& gap) { gap_ = direction_of(gap).n; }
  /// Between the closest points, and how fast it grows.
  COLLIDED_HD Work gap() const { return length_; }
  COLLIDED_HD Work speed() const { return speed_; }

 private:
  /// The direction or its opposite, to the first feature's side.
  COLLIDED_HD Direction<Work> facing(const Direction<Work>& direction) const {
    Work most = 0;
    for (int k = 0; k < N; ++k) {
      const Work g = dot(direction.n, x_[k]);
      if (magnitude(g) > magnitude(most)) most = g;
    }
    return most < 0 ? Direction<Work>{Work(-1) * direction.n, direction.length} : direction;
  }

  Work length_, speed_;
  Vec3<Work> x_[N], gap_, edges_[kEdges], axes_[kAxes], normal_;
};

/// True if features that are `gap` apart at t are so far beyond the thickness that more precise directions may separate
/// them: by more than delta and what certificates lose to rounding.
template <class Work, int N>
COLLIDED_HD bool may_be_near_miss(const Differences<Work, N>& d, const Tolerance<Work>& tolerance, Work t, Work gap) {
  constexpr Work kLost = 32 * Precision<Work>::kUnit;
  const Work beyond = tolerance.delta + kLost * d.extent;
  return gap > (1 - t) * tolerance.thickness.start + t * tolerance.thickness.end + beyond;
}

/// True if one of the directions at t separates the features then; false says nothing.
template <class Work, int N>
COLLIDED_HD bool are_precisely_apart(const Differences<Work, N>& d, const Thickness<Work>& thickness, Work t) {
  const PreciseDirections<Work, N> directions(d, t);
  for (uint32_t k = 0; k < PreciseDirections<Work, N>::kCount; ++k)
    if (along(d, directions[k], thickness, t).is_apart()) return true;
  return false;
}

/// The outcome for features that advancement.hpp reported as a contact.
struct NearMiss {
  bool is_hit, is_capped;
  double t;  ///< apart on [0, t) for certain
};

/// True if one of the directions, while it turns from what it is at t to what it is at h, separates the features. The
/// threads of the team share the directions, and all of them call.
template <class Work, int N>
COLLIDED_HD bool apart_between(const Differences<Work, N>& d, const Thickness<Work>& thickness,
                               const PreciseDirections<Work, N>& from, Work t, const PreciseDirections<Work, N>& to,
                               Work h, const Group& team) {
  bool is_apart = false;
  for (uint32_t k = team.rank; k < PreciseDirections<Work, N>::kCount && !is_apart; k += team.size)
    is_apart = apart_while_turning(along(d, from[k], thickness, t), along(d, to[k], thickness, h), t, h);
  return team.any(is_apart);
}

/// The farthest time until which a fixed direction separates the features by more than delta; t if none does.
template <class Work, int N>
COLLIDED_HD Work reach_of_fixed(const Differences<Work, N>& d, const Tolerance<Work>& tolerance,
                                const PreciseDirections<Work, N>& now, Work t, const Group& team) {
  Work until = t;
  for (uint32_t k = team.rank; k < PreciseDirections<Work, N>::kCount; k += team.size) {
    const Reach<Work> reach = along(d, now[k], tolerance.thickness, t).reach();
    if (reach.separation > tolerance.delta) until = max(until, reach.until);
  }
  return team.most(until);
}

/// Continues an advancement that ended in a contact at t. Each iteration tries a step of four times the last one's
/// length, or a quarter of it after a failure, then Newton's, then as far as a fixed direction reaches. Newton's alone
/// does not do: the speed of a gap of 1e-13 is mostly rounding. A team of threads takes the same course as one thread.
template <class Work, int N>
COLLIDED_HD NearMiss follow_near_miss(const Differences<Work, N>& d, const Tolerance<Work>& tolerance, Work t,
                                      const Group& team) {
  using Directions = PreciseDirections<Work, N>;
  const Work rounding = 8 * Precision<Work>::kUnit * d.extent;
  Pace pace;
  Work step = 1 - t;
  for (int i = 0; i <= kMaxIterations; ++i) {
    const Directions now(d, t);
    const Work until = reach_of_fixed(d, tolerance, now, t, team);
    if (until > 1) return {false, false, 1};
    if (!(until > t)) return {true, false, t};
    const Work far = min(t + step, Work(1));
    Work next = until;
    if (far > until && apart_between(d, tolerance.thickness, now, t, Directions(d, far), far, team)) {
      if (far == 1) return {false, false, 1};
      next = far, step = 4 * step;
    } else {
      step = max(step / 4, 2 * (until - t));
      const Work ahead = pace.ahead_of(t, now.gap() - tolerance.thickness.end, now.speed(), rounding);
      if (ahead > until) {
        const Directions then(d, ahead);
        if (apart_between(d, tolerance.thickness, now, t, then, ahead, team)) {
          if (ahead == 1) return {false, false, 1};
          pace.succeed(ahead - t, now.gap(), now.speed(), then.gap());
          next = ahead;
        } else {
          pace.fail(ahead - t);
        }
      }
    }
    t = next;
  }
  return {true, true, t};
}

}  // namespace collided
