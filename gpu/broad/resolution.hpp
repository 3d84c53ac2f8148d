#pragma once
// How fine the positions are, compared with the scene's triangles.

#include "gpu/broad/boxes.hpp"
#include "gpu/exec/atomic.hpp"

namespace collided {

/// Distance of neighbouring numbers at the largest coordinate in the bounds.
template <class Real>
COLLIDED_HD Real spacing_at(const Box<float>& bounds) {
  constexpr float kMost = 0x1.fffffep127f;
  const float m = smaller(larger(largest_component(bounds.lo), largest_component(bounds.hi)), kMost);
  const Real at = static_cast<Real>(m);
  return at - next_down(at);
}

/// Counts the triangles that are nowhere longer than 1024 spacings. Their boxes would not tell: these are rounded
/// outward to float.
template <class Real>
struct CountSmall {
  const Box<float>* bounds;
  TriangleRecords<Real> records;
  uint64_t* count;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Real limit = 1024 * spacing_at<Real>(*bounds);
    const uint32_t t = static_cast<uint32_t>(i);
    const Vec3<Real> a = records.corner(t, 0).end, b = records.corner(t, 1).end, c = records.corner(t, 2).end;
    if (largest_component(a - b) < limit && largest_component(b - c) < limit && largest_component(c - a) < limit)
      claim_slot(*count);
  }
};

}  // namespace collided
