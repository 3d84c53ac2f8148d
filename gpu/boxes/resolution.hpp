#pragma once
// How fine the positions are, compared with the scene's triangles.

#include "gpu/boxes/boxes.hpp"
#include "gpu/exec/atomic.hpp"

namespace collided {

/// Distance of neighbouring numbers at the largest coordinate in the bounds.
template <class Real>
COLLIDED_HD Real spacing_at(const Box<float>& bounds) {
  constexpr float kMax = 0x1.fffffep127f;
  const float m = min(max(largest_component(bounds.lo), largest_component(bounds.hi)), kMax);
  const Real at = static_cast<Real>(m);
  return at - next_down(at);
}

/// Counts the triangles and loose edges that are nowhere longer than 1024 spacings; points have no length. Their boxes
/// would not tell: these are rounded outward to float.
template <class Real>
struct CountSmall {
  const Box<float>* bounds;
  TriangleRecords<Real> records;
  uint64_t* count;
  SteppedWorlds stepped = {};

  COLLIDED_HD void operator()(uint64_t i) const {
    const Real limit = 1024 * spacing_at<Real>(*bounds);
    if (!stepped.has(i)) return;
    const TriangleRecord<Real>& t = records[i];
    if (t.corner[0].vertex == t.corner[1].vertex) return;
    const Vec3<Real> a = end_of(t.corner[0]), b = end_of(t.corner[1]), c = end_of(t.corner[2]);
    if (is_below(limit, a - b) && is_below(limit, b - c) && is_below(limit, c - a)) claim_slot(*count);
  }

 private:
  COLLIDED_HD Vec3<Real> end_of(const CornerRecord<Real>& corner) const {
    return records.path(corner, corner.vertex).end;
  }
  COLLIDED_HD static bool is_below(Real limit, const Vec3<Real>& side) { return largest_component(side) < limit; }
};

}  // namespace collided
