#pragma once
// How long two features stay farther apart than a distance of their own, on straight ways. The certificates are those
// of CCD at CERTIFIED, with a third kind of direction before them: the common normal of the features, which turns with
// them. Features that are 1e-8 of their size apart and turn together have no other.

#include "gpu/narrow/near_miss.hpp"

namespace collided {

namespace detail {

/// A vector as it is; too short a one is no direction, for its square says nothing of its length.
COLLIDED_HD inline Direction<double> unscaled_direction(const Vec3<double>& v) {
  const double squared = dot(v, v);
  return {v, squared > Precision<double>::kTiny / Precision<double>::kUnit ? square_root(squared) : 0.0};
}

/// Lower bound of a + 2 b, from lower bounds of both.
COLLIDED_HD inline double lower_bound_of_sum(double a, double b) {
  return (a + 2 * b) - 4 * Precision<double>::kUnit * (magnitude(a) + 2 * magnitude(b));
}

}  // namespace detail

/// True if the features' common normal N separates them by more than the thickness all along. N is quadratic in t; with
/// control vectors N_i and differences from D_0 to D_1, N . D - thickness |N| is at least the cubic whose Bernstein
/// coefficients are (1, 2, 2, 1 times) averages of l(i, j) = N_i . D_j - thickness |N_i|. So it is above 0 if all of
/// these are. The control vectors are data: what rounding they carry makes another direction, not a wrong bound.
template <int N>
COLLIDED_HD bool normals_separate_all_along(const Differences<double, N>& d, double thickness) {
  constexpr int kEdges = N == 3 ? 3 : 2;
  Vec3<double> from[kEdges], to[kEdges];
  detail::edges_of(d.start, from);
  detail::edges_of(d.end, to);
  Vec3<double> normals[3] = {cross(from[0], from[1]), 0.5 * (cross(from[0], to[1]) + cross(to[0], from[1])),
                             cross(to[0], to[1])};
  const double side = dot(normals[0], d.start[0]) < 0 ? -1.0 : 1.0;
  Direction<double> directions[3];
  double offsets[3];
  for (int i = 0; i < 3; ++i) {
    directions[i] = detail::unscaled_direction(side * normals[i]);
    if (!(directions[i].length > 0)) return false;
    offsets[i] = offset_along(directions[i], thickness);
  }
  for (int k = 0; k < N; ++k) {
    const auto bound = [&](int i, const Vec3<double>& x) { return lower_bound_along(directions[i].n, x, offsets[i]); };
    const bool is_apart = bound(0, d.start[k]) > 0 && bound(2, d.end[k]) > 0 &&
                          detail::lower_bound_of_sum(bound(0, d.end[k]), bound(1, d.start[k])) > 0 &&
                          detail::lower_bound_of_sum(bound(2, d.start[k]), bound(1, d.end[k])) > 0;
    if (!is_apart) return false;
  }
  return true;
}

/// How far a way is certain to be free.
struct CertifiedWay {
  bool is_free;  ///< all of it
  double until;  ///< on [0, until) for certain
};

/// Returns for how long the features are farther apart than the distance, which is in the units of the positions. All
/// threads of a team call.
template <int N>
COLLIDED_LONG COLLIDED_HD CertifiedWay certified_way(const Differences<double, N>& d, double distance,
                                                     const Group& team = Group{0, 1}) {
  const double thickness = scaled_thickness<double>(distance, d.scale);
  if (normals_separate_all_along(d, thickness)) return {true, 1};
  const Tolerance<double> tolerance{{thickness, thickness}, default_delta(0.0) * d.extent};
  Advancement<double, N> search;
  search.d = d;
  search.begin(tolerance, Progress{}, kMaxIterations);
  while (!search.is_over()) search.iterate(1.0);
  if (!search.is_hit()) return {true, 1};
  if (!may_be_near_miss(d, tolerance, search.time(), search.gap())) return {false, search.time()};
  const NearMiss found = follow_near_miss(d, tolerance, search.time(), team);
  return {!found.is_hit, found.t};
}

}  // namespace collided
