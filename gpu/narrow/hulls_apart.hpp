#pragma once
// Pairs that stay apart whatever fractions their vertices take. Every vertex ends between its start x and its target p,
// at a fraction of its own. The test looks for a plane that separates all x and p of one feature from all x and p of
// the other. The gap must be the distance asked for, and what rounding may move a vertex off its straight way. Then the
// features stay apart at every fraction, at the end of the step and on the way.

#include "gpu/exec/atomic.hpp"
#include "gpu/narrow/certified_ccd.hpp"
#include "gpu/narrow/floors.hpp"

namespace collided {

/// True if the direction parts everything that both features may reach by more than `distance`; false says nothing.
/// `off`: how far each coordinate may be off the straight way. `scale`: of the differences that n was made from.
template <class Kind, class Real>
COLLIDED_HD bool hulls_are_apart_along(const Direction<double>& direction, const FeaturePoints<Real>& p,
                                       double distance, double off, double scale) {
  constexpr int kFirst = DifferenceOf<Kind>::kCount == 3 ? 1 : 2;
  if (!(direction.length > 0)) return false;
  const Vec3<double>& n = direction.n;
  const double sum = magnitude(n.x) + magnitude(n.y) + magnitude(n.z);
  const double widened = scaled_thickness<double>(off, scale) * (2 * sum);
  const double offset = (offset_along(direction, scaled_thickness<double>(distance, scale)) + widened) *
                        (1 + 16 * Precision<double>::kUnit);
  bool is_apart = true;
  for (int i = 0; i < kFirst; ++i)
    for (int j = kFirst; j < 4; ++j)
      for (const Vec3<Real>* a : {&p.start[i], &p.end[i]})
        for (const Vec3<Real>* b : {&p.start[j], &p.end[j]}) {
          const Vec3<double> difference = scale * (convert<double>(*a) - convert<double>(*b));
          is_apart = is_apart && lower_bound_along(n, difference, offset) > 0;
        }
  return is_apart;
}

/// What hulls_are_apart() says of a pair, or of four, at a glance: in float, along one direction. It is enough for most
/// candidates. `d`: their differences. Work is float, and Real what positions have; or four of either.
template <class Kind, class Work, class Real>
COLLIDED_HD Mask<Work> hulls_are_apart_at_a_glance(const DifferencesOf<Work, Kind>& d, const FeaturePoints<Real>& p,
                                                   const DoubleOf<Real>& distance) {
  using Difference = DifferenceOf<Kind>;
  using Wide = DoubleOf<Real>;
  constexpr int kFirst = Difference::kCount == 3 ? 1 : 2;
  const Direction<Work> direction = direction_of(gap_at(d, Work(0.5f)).vector);
  const Wide off = PositionNoise<Real>::kOfBlend * largest_coordinate(p);
  const Work offset = offset_along(direction, scaled_thickness<Work>(distance + 4 * off, d.scale));
  Work approach[4];  // how far each vertex can come nearer along the direction, at most
  for (int i = 0; i < 4; ++i) {
    const Vec3<Wide> way = convert<Wide>(p.end[i]) - convert<Wide>(p.start[i]);
    const Vec3<Work> n = i < kFirst ? direction.n : Work(-1) * direction.n;
    approach[i] = max(Work(0) - lower_bound_along(n, convert<Work>(d.scale * way), Work(0)), Work(0));
  }
  Mask<Work> is_apart = direction.length > 0;
  for (int k = 0; k < Difference::kCount; ++k) {
    const Work most = approach[Difference::minuend(k)] + approach[Difference::subtrahend(k)];
    is_apart =
        is_apart && lower_bound_along(direction.n, d.start[k], offset) > most * (1 + 4 * Precision<Work>::kUnit);
  }
  return is_apart;
}

/// The same by a closer look, in double, along several directions.
template <class Kind, class Real>
COLLIDED_LONG COLLIDED_HD bool hulls_are_apart_closely(const FeaturePoints<Real>& p, double distance) {
  DifferencesOf<double, Kind> d;
  if (!load_differences<Kind, double>(p, d)) return false;
  const double off = PositionNoise<Real>::kOfBlend * largest_coordinate(p);
  constexpr uint32_t kTried = 4;  // the vector between the closest points, and its rejections from edges
  for (const double t : {0.0, 0.5, 1.0}) {
    const PreciseDirections<double, DifferenceOf<Kind>::kCount> directions(d, t);
    for (uint32_t k = 0; k < kTried; ++k)
      if (hulls_are_apart_along<Kind>(directions[k], p, distance, off, d.scale)) return true;
  }
  return false;
}

/// True if the features stay farther apart than `distance` for certain, and end so, however far each of their vertices
/// goes from p.start towards p.end. False says nothing.
template <class Kind, class Real>
COLLIDED_HD bool hulls_are_apart(const FeaturePoints<Real>& p, double distance) {
  DifferencesOf<float, Kind> d;
  if (load_differences<Kind, float>(p, d) && hulls_are_apart_at_a_glance<Kind>(d, p, distance)) return true;
  return hulls_are_apart_closely<Kind>(p, distance);
}

/// The distance of hulls, of pairs that no fractions are to bring within `reach`. `largest`: coordinate of the pair.
template <class Real>
COLLIDED_HD DoubleOf<Real> hulls_distance(double reach, const DoubleOf<Real>& largest) {
  return reach + PositionNoise<Real>::kOfFloor * largest;
}

/// Candidates of one kind whose vertices go from `start` to `target`.
template <class Real, class Kind>
struct HullsOfPairs {
  const Vec3<Real>* start;
  const Vec3<Real>* target;
  Kind kind;
  double reach;  ///< that no fractions are to bring the pairs within
  Span<const uint64_t> candidates;

  COLLIDED_HD FeaturePoints<Real> way(uint64_t i) const { return points_of(kind.stencil(candidates[i]), start, target); }
};

/// Keeps the candidates that a glance does not tell apart. Contacts are among them.
template <class Real, class Kind>
struct GlanceAtHulls {
  HullsOfPairs<Real, Kind> pairs;
  double contacts_within;  ///< what the positions of their features say
  Deviations deviations;
  AppendList<uint64_t> survivors;

  COLLIDED_HD double reach() const {
    return max(pairs.reach, Deviations::widened(contacts_within, deviations.of_any_pair()));
  }

  COLLIDED_HD void operator()(uint64_t i) const {
    const FeaturePoints<Real> way = pairs.way(i);
    DifferencesOf<float, Kind> d;
    if (load_differences<Kind, float>(way, d) &&
        hulls_are_apart_at_a_glance<Kind>(d, way, hulls_distance<Real>(reach(), largest_coordinate(way))))
      return;
    survivors.push(pairs.candidates[i]);
  }
};

/// Keeps those of them that a closer look does not tell apart either. A glance from farther away may have kept them.
template <class Real, class Kind>
struct LookAtHulls {
  HullsOfPairs<Real, Kind> pairs;
  AppendList<uint64_t> survivors;

  COLLIDED_HD void operator()(uint64_t i) const {
    const FeaturePoints<Real> way = pairs.way(i);
    if (!hulls_are_apart<Kind>(way, hulls_distance<Real>(pairs.reach, largest_coordinate(way))))
      survivors.push(pairs.candidates[i]);
  }
};

}  // namespace collided
