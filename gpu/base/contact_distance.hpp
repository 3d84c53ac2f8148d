#pragma once
// Contact distances are sums of three numbers.

#include "gpu/base/rounding.hpp"

namespace collided {

/// The distance within which two features are in contact: the real sum of three numbers >= 0. No double need be that
/// sum.
struct ContactDistance {
  double thickness = 0;          ///< the scene's
  double first = 0, second = 0;  ///< half thicknesses of the features' meshes

  ContactDistance() = default;
  COLLIDED_HD ContactDistance(double alone) : thickness(alone) {}  // NOLINT: a number is a distance
  COLLIDED_HD ContactDistance(double thickness, double first, double second)
      : thickness(thickness), first(first), second(second) {}

  COLLIDED_HD bool is_zero() const { return thickness == 0 && first == 0 && second == 0; }
  /// Returns a double that is not below the sum: the sum itself if only one number is not 0.
  COLLIDED_HD double above() const { return sum_above(sum_above(thickness, first), second); }
  /// Returns a double that is not above the sum, likewise. It is 0 only if the sum is.
  COLLIDED_HD double below() const { return sum_below(sum_below(thickness, first), second); }
  COLLIDED_HD double nearly() const { return thickness + first + second; }
};

}  // namespace collided
