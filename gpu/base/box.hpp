#pragma once
// Axis-aligned boxes, closed on every side.

#include "gpu/base/rounding.hpp"
#include "gpu/base/vec3.hpp"

namespace collided {

template <class Real>
struct Box {
  Vec3<Real> lo, hi;
};

template <class Real>
COLLIDED_HD Box<Real> join(const Box<Real>& a, const Box<Real>& b) {
  return {{min(a.lo.x, b.lo.x), min(a.lo.y, b.lo.y), min(a.lo.z, b.lo.z)},
          {max(a.hi.x, b.hi.x), max(a.hi.y, b.hi.y), max(a.hi.z, b.hi.z)}};
}

/// Meets no box within float's range, and adds nothing to another.
COLLIDED_HD inline Box<float> no_box() {
  constexpr float kMax = 0x1.fffffep127f;
  return {{kMax, kMax, kMax}, {-kMax, -kMax, -kMax}};
}

COLLIDED_HD inline bool is_no_box(const Box<float>& box) { return box.lo.x > box.hi.x; }

template <class Real>
COLLIDED_HD bool overlap(const Box<Real>& a, const Box<Real>& b) {
  return a.lo.x <= b.hi.x && b.lo.x <= a.hi.x && a.lo.y <= b.hi.y && b.lo.y <= a.hi.y && a.lo.z <= b.hi.z &&
         b.lo.z <= a.hi.z;
}

/// Grown by r >= 0 on every side, rounded outward; exact for r = 0.
template <class Real>
COLLIDED_HD Box<Real> inflate(const Box<Real>& b, Real r) {
  if (r == 0) return b;
  return {{next_down(b.lo.x - r), next_down(b.lo.y - r), next_down(b.lo.z - r)},
          {next_up(b.hi.x + r), next_up(b.hi.y + r), next_up(b.hi.z + r)}};
}

/// The least float box that contains b.
template <class Real>
COLLIDED_HD Box<float> outward_float(const Box<Real>& b) {
  return {{float_below(b.lo.x), float_below(b.lo.y), float_below(b.lo.z)},
          {float_above(b.hi.x), float_above(b.hi.y), float_above(b.hi.z)}};
}

/// Whether boxes overlap whose least float boxes these are. No answer where bounds are next to each other.
COLLIDED_HD inline bool surely_overlap(const Box<float>& a, const Box<float>& b) {
  const auto is_below = [](float lo, float hi) {
    // The left side is above lo. What lo stands for is below the next float, what hi stands for is not.
    return lo + (magnitude(lo) * 0x1p-22f + 0x1p-126f) < hi;
  };
  return is_below(a.lo.x, b.hi.x) && is_below(b.lo.x, a.hi.x) && is_below(a.lo.y, b.hi.y) && is_below(b.lo.y, a.hi.y) &&
         is_below(a.lo.z, b.hi.z) && is_below(b.lo.z, a.hi.z);
}

/// Positions at both ends of the step. For DCD both name the same array.
template <class Real>
struct Motion {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  Real inflation;  ///< half the thickness
};

}  // namespace collided
