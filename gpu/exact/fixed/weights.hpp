#pragma once
// The weights of the features' common point at a root of their volume, in double precision.
//
// They are cross products times the normal, as in exact/features.cpp, and not negative if the features meet. The root
// is in [k, k + 1] / 2^60. With u = 2^-53, components that are at most L and change by at most V there, and are known
// at k within 2^-51 of each and 2^-96 L:
// - a weight is at most 48 products of four, and all roundings together are below 2048u L^4,
// - it changes by at most 4 * 48 V L^3.

#include "gpu/exact/fixed/differences.hpp"

namespace collided::exact::fixed {

template <ContactKind kind>
class Weights {
 public:
  static constexpr int kCount = Sides<kind>::kCount;

  /// d: the features' differences (Differences) at k, of which no component is above `largest` in the interval, or
  /// changes by more than `change`.
  COLLIDED_HD Weights(const Vec3<double>* d, double largest, double change)
      : error_((2048 * 0x1p-53 * largest + 256 * change) * (largest * largest * largest)) {
    Vec3<double> sides[kCount];
    for (int i = 0; i < kCount; ++i) sides[i] = cross(d[Sides<kind>::at(i).p], d[Sides<kind>::at(i).q]);
    const Vec3<double> n = normal_of<kind>(sides);
    for (int i = 0; i < kCount; ++i) weights_[i] = dot(sides[i], n);
  }
  COLLIDED_HD bool is_negative(int side) const { return weights_[side] < -error_; }
  COLLIDED_HD bool is_positive(int side) const { return weights_[side] > error_; }
  COLLIDED_HD bool are_positive() const {
    bool all = true;
    for (int i = 0; i < kCount; ++i) all = all && is_positive(i);
    return all;
  }

 private:
  double weights_[kCount], error_;
};

}  // namespace collided::exact::fixed
