#pragma once
// Resting contact: features that begin a step within the thickness and come no closer in it. The bounds are those of
// certificate.hpp and separation.hpp.

#include "gpu/narrow/certificate.hpp"

namespace collided {

/// What features that part or rest may lose of their distance in a step, for all that is certain. Less would make
/// rounding decide for features that are a billionth of their size apart.
constexpr double kLostAtRest = 0x1p-20;

/// Of their size: features that are closer than this at t = 0 are never certain to lose less.
constexpr double kTooClose = 0x1p-28;

/// Whether the features are certain to stay apart, over the whole step, by more than 1 - kLostAtRest of their distance
/// at t = 0, and by more than `least` (scaled). False says nothing.
template <int N>
COLLIDED_HD bool comes_no_closer(const Differences<double, N>& d, double least) {
  constexpr double u = Precision<double>::kUnit;
  const double distance = gap_at(d, 0.0).length * (1 + 8 * u) + 64 * u * d.extent;  // no less than the true one
  const double kept = max((1 - kLostAtRest) * distance, least);
  const ClosestFeatures<double, N> closest_features(d, 0.0);
  return apart_all_along(d, closest_features.best(), kept) || apart_all_along(d, closest_features.other(), kept);
}

}  // namespace collided
