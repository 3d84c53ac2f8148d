#pragma once
// Pairs that start so near each other that certificates in double tell little of them (floors.hpp). Such a pair may
// move if it comes no nearer along one fixed direction that separates it at the start: then that direction separates it
// all along, for ways are straight. Or it moves as one, or integers decide (step/blocking_pairs.hpp).

#include "gpu/base/points.hpp"
#include "gpu/base/precision.hpp"
#include "gpu/base/twofold.hpp"
#include "gpu/narrow/features.hpp"

namespace collided {

namespace detail {

/// True if a - b = c - d in real arithmetic.
COLLIDED_HD inline bool is_same_difference(double a, double b, double c, double d) {
  const Twofold first = exact_sum(a, -b), second = exact_sum(c, -d);
  return first.high == second.high && first.low == second.low;
}

/// One term of a direction times a difference's change, of one axis.
struct ChangeTerm {
  double value, magnitude;  ///< the value is within 8u of the magnitude of the truth, underflow aside
};

/// The difference goes from x_i - x_j to y_i - y_j.
COLLIDED_HD inline ChangeTerm change_along_axis(double n, double x_i, double y_i, double x_j, double y_j) {
  if (n == 0 || is_same_difference(y_i, x_i, y_j, x_j)) return {0, 0};
  const double way_i = y_i - x_i, way_j = y_j - x_j;
  return {n * (way_i - way_j), collided::magnitude(n) * (collided::magnitude(way_i) + collided::magnitude(way_j))};
}

}  // namespace detail

/// True if the features' vertices all go the same way, to the last bit: they stand in a frame that moves.
template <class Real>
COLLIDED_HD bool moves_as_one(const FeaturePoints<Real>& p) {
  const auto is_same = [&](int i, Real Vec3<Real>::*axis) {
    return detail::is_same_difference(p.end[i].*axis, p.start[i].*axis, p.end[0].*axis, p.start[0].*axis);
  };
  for (int i = 1; i < 4; ++i)
    if (!is_same(i, &Vec3<Real>::x) || !is_same(i, &Vec3<Real>::y) || !is_same(i, &Vec3<Real>::z)) return false;
  return true;
}

/// True if no difference of the features' vertices is certain to be less along n at the end than at the start. False
/// says nothing. Components of n are below 2.
template <class Kind, class Real>
COLLIDED_HD bool comes_no_nearer_along(const Vec3<double>& n, const FeaturePoints<Real>& p) {
  using Difference = DifferenceOf<Kind>;
  for (int k = 0; k < Difference::kCount; ++k) {
    const Vec3<double> x_i = convert<double>(p.start[Difference::minuend(k)]);
    const Vec3<double> y_i = convert<double>(p.end[Difference::minuend(k)]);
    const Vec3<double> x_j = convert<double>(p.start[Difference::subtrahend(k)]);
    const Vec3<double> y_j = convert<double>(p.end[Difference::subtrahend(k)]);
    const detail::ChangeTerm x = detail::change_along_axis(n.x, x_i.x, y_i.x, x_j.x, y_j.x);
    const detail::ChangeTerm y = detail::change_along_axis(n.y, x_i.y, y_i.y, x_j.y, y_j.y);
    const detail::ChangeTerm z = detail::change_along_axis(n.z, x_i.z, y_i.z, x_j.z, y_j.z);
    const double magnitude = x.magnitude + y.magnitude + z.magnitude;
    const double error = 16 * Precision<double>::kUnit * magnitude + Precision<double>::kTiny;
    const bool is_unchanged = magnitude == 0 && x.value == 0 && y.value == 0 && z.value == 0;
    if (!is_unchanged && !(x.value + y.value + z.value > error)) return false;
  }
  return true;
}

}  // namespace collided
