#pragma once
// Pairs that stay apart whatever fractions their vertices take. Every vertex ends between its start x and its target p,
// at a fraction of its own. The test looks for a plane that separates all x and p of one feature from all x and p of
// the other. The gap must be the distance asked for, and what rounding may move a vertex off its straight way. Then the
// features stay apart at every fraction, at the end of the step and on the way.

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

/// What hulls_are_apart() says of a pair, at a glance: in float, along one direction. It is enough for most candidates.
template <class Kind, class Real>
COLLIDED_HD bool hulls_are_apart_in_float(const FeaturePoints<Real>& p, double distance) {
  using Difference = DifferenceOf<Kind>;
  constexpr int kFirst = Difference::kCount == 3 ? 1 : 2;
  DifferencesOf<float, Kind> d;
  if (!load_differences<Kind, float>(p, d)) return false;
  const Direction<float> direction = direction_of(gap_at(d, 0.5f).vector);
  if (!(direction.length > 0)) return false;
  const double off = PositionNoise<Real>::kOfBlend * largest_coordinate(p);
  const float offset = offset_along(direction, scaled_thickness<float>(distance + 4 * off, d.scale));
  float approach[4];  // how far each vertex can come nearer along the direction, at most
  for (int i = 0; i < 4; ++i) {
    const Vec3<double> way = convert<double>(p.end[i]) - convert<double>(p.start[i]);
    const Vec3<float> n = (i < kFirst ? 1.0f : -1.0f) * direction.n;
    approach[i] = max(-lower_bound_along(n, convert<float>(d.scale * way), 0.0f), 0.0f);
  }
  bool is_apart = true;
  for (int k = 0; k < Difference::kCount; ++k) {
    const float most = approach[Difference::minuend(k)] + approach[Difference::subtrahend(k)];
    is_apart =
        is_apart && lower_bound_along(direction.n, d.start[k], offset) > most * (1 + 4 * Precision<float>::kUnit);
  }
  return is_apart;
}

/// True if the features stay farther apart than `distance` for certain, and end so, however far each of their vertices
/// goes from p.start towards p.end. False says nothing.
template <class Kind, class Real>
COLLIDED_LONG COLLIDED_HD bool hulls_are_apart(const FeaturePoints<Real>& p, double distance) {
  if (hulls_are_apart_in_float<Kind>(p, distance)) return true;
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

}  // namespace collided
