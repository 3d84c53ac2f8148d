#pragma once
// A lower bound of the distance of two features that stand still. It is a number, so that a step can keep what an
// earlier one left: certified_proximity.hpp only answers yes or no.
//
// The bound is that of separation.hpp for the best of PreciseDirections (near_miss.hpp), so it is never above the true
// distance, whatever the directions are. It depends on the four positions alone: the end of one step and the start of
// the next give the same bits. It falls short of the distance by at most 20 u of the extent and the distance together.
// The rejections make a direction precise across each edge and plane of the features; an error within these counts only
// by its square. This is measured, not proved (certified_distance_test.cpp, with slivers and nearly parallel edges).

#include "gpu/narrow/near_miss.hpp"

namespace collided {

/// A lower bound of a distance, and the direction that gives it.
struct CertifiedDistance {
  double value = 0;           ///< in the units of the positions; 0 if no direction separates the features
  Direction<double> along{};  ///< to the first feature's side; of length 0 if none separates them
  double extent = 0;          ///< the largest component of the differences, in the units of the positions
};

namespace detail {

/// Returns value / scale, rounded down; the scale is a power of two. The quotient may be subnormal.
COLLIDED_HD inline double unscaled_below(double value, double scale) {
  const double quotient = value / scale;
  return quotient * scale > value ? next_down(quotient) : quotient;
}

/// Returns a lower bound of the distance that a direction certifies between features with these differences, scaled.
template <int N>
COLLIDED_HD double certified_along(const Vec3<double> (&x)[N], const Direction<double>& direction) {
  constexpr double u = Precision<double>::kUnit;
  if (!(direction.length > 0)) return 0;
  double least = lower_bound_along(direction.n, x[0], 0.0);
  for (int k = 1; k < N; ++k) least = min(least, lower_bound_along(direction.n, x[k], 0.0));
  if (!(least > 0)) return 0;
  // The length is within 3u of the truth; the product and the quotient take two roundings, the last line another.
  const double bound = least / (direction.length * (1 + 8 * u));
  return bound - 4 * u * bound;
}

}  // namespace detail

/// Returns the best lower bound of the distance at t = 0. The features must stand still: start and end are the same.
/// The threads of a team share the directions. All of them call, and each gets what one thread alone would.
template <int N>
COLLIDED_LONG COLLIDED_HD CertifiedDistance certified_distance(const Differences<double, N>& d,
                                                               const Group& team = Group{0, 1}) {
  constexpr uint32_t kNone = ~0u;
  const PreciseDirections<double, N> directions(d, 0.0);
  CertifiedDistance best;
  double most = 0;
  uint32_t first = kNone;
  for (uint32_t k = team.rank; k < PreciseDirections<double, N>::kCount; k += team.size) {
    const Direction<double> direction = directions[k];
    const double bound = detail::certified_along(d.start, direction);
    if (bound > most) most = bound, first = k, best.along = direction;
  }
  if (team.size > 1) {
    const double of_all = team.most(most);
    first = team.least(most == of_all ? first : kNone);
    most = of_all;
    if (first != kNone) best.along = directions[first];
  }
  best.value = detail::unscaled_below(most, d.scale);
  best.extent = d.extent / d.scale;
  return best;
}

/// The same of the features of a kind with these vertices, in the order of Kind::stencil.
template <class Kind, class Real>
COLLIDED_HD CertifiedDistance certified_distance(const Vec3<Real> (&p)[4], const Group& team = Group{0, 1}) {
  FeaturePoints<Real> points;
  for (int i = 0; i < 4; ++i) points.start[i] = points.end[i] = p[i];
  DifferencesOf<double, Kind> d;
  return load_differences<Kind, double>(points, d) ? certified_distance(d, team) : CertifiedDistance{};
}

}  // namespace collided
