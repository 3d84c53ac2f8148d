#pragma once
// Section 3: the bounding box of every triangle: over the step for CCD, of the frame for DCD, inflated by half
// the thickness, rounded outward to float.

#include <limits>

#include "gpu/math/lattice.hpp"

namespace collided {

using Triangle = Vec3<uint32_t>;

template <class Real>
struct BoxTriangles {
  Motion<Real> motion;
  Span<const Triangle> triangles;
  uint64_t first;
  Span<Box<float>> boxes;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Triangle t = triangles[first + i];
    boxes[first + i] = outward_float(motion.triangle_box(t.x, t.y, t.z));
  }
};

struct BoxOf {
  Span<const Box<float>> boxes;
  COLLIDED_HD Box<float> operator()(uint64_t i) const { return boxes[i]; }
};
struct JoinBoxes {
  COLLIDED_HD Box<float> operator()(const Box<float>& a, const Box<float>& b) const { return join(a, b); }
};
inline Box<float> empty_box() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  return {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
}

/// The cube of the hierarchy over the scene's bounds.
inline LevelGrid grid_over(const Box<float>& bounds, int top, int base) {
  const Vec3<float> extent = bounds.hi - bounds.lo;
  const float side = larger(extent.x, larger(extent.y, extent.z));
  const float scale = side > 0 ? static_cast<float>(1u << base) / side : 0.0f;
  return {bounds.lo, smaller(scale, std::numeric_limits<float>::max()), top, base};
}

}  // namespace collided
