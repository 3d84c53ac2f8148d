#pragma once
// How large boxes are on average, in whole numbers, so that the sum does not depend on the order.

#include "gpu/base/box.hpp"

namespace collided {

/// Largest side, 0 for a box without points.
COLLIDED_HD inline double largest_side(const Box<float>& b) {
  const double x = double{b.hi.x} - double{b.lo.x}, y = double{b.hi.y} - double{b.lo.y},
               z = double{b.hi.z} - double{b.lo.z};
  return max(x, max(y, max(z, 0.0)));
}

/// A box's largest side, in units of the scene's / 2^32. Of doubles beyond float's range boxes are infinite, and then
/// as large as the scene.
COLLIDED_HD inline uint64_t extent_of(const Box<float>& box, const Box<float>& bounds) {
  const double side = largest_side(bounds);
  if (!(side > 0)) return 0;
  const double share = largest_side(box) / side;  // NaN: both are infinite
  return static_cast<uint64_t>((share <= 1 ? share : 1) * 0x1p32);
}

struct ExtentOf {
  const Box<float>* bounds;
  Span<const Box<float>> boxes;
  COLLIDED_HD uint64_t operator()(uint64_t i) const { return extent_of(boxes[i], *bounds); }
};
struct AddExtents {
  COLLIDED_HD uint64_t operator()(uint64_t a, uint64_t b) const { return a + b; }
};

/// The mean of all triangles' extents.
struct MeanExtent {
  const Box<float>* bounds;
  const uint64_t* sum;
  uint64_t triangles;

  COLLIDED_HD double operator()() const {
    return static_cast<double>(*sum) / static_cast<double>(triangles) * 0x1p-32 * largest_side(*bounds);
  }
  /// Whether a box is more than `times` as large; neither product exceeds 64 bits.
  COLLIDED_HD bool is_exceeded(const Box<float>& box, uint64_t times) const {
    return extent_of(box, *bounds) * triangles / times > *sum;
  }
};

}  // namespace collided
