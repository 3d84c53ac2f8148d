#pragma once
// How fine the positions are, compared with the scene's triangles.

#include "gpu/exec/atomic.hpp"
#include "gpu/search/boxes.hpp"

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
  Span<const TriangleRecord<Real>> records;
  uint64_t* count;
  SteppedWorlds stepped = {};

  COLLIDED_HD void operator()(uint64_t i) const {
    const Real limit = 1024 * spacing_at<Real>(*bounds);
    if (!stepped.has(i)) return;
    const TriangleRecord<Real>& t = records[i];
    if (t.corner[0].vertex_id() == t.corner[1].vertex_id()) return;
    if (is_short(t, 0, 1, limit) && is_short(t, 1, 2, limit) && is_short(t, 2, 0, limit)) claim_slot(*count);
  }

 private:
  COLLIDED_HD static bool is_short(const TriangleRecord<Real>& t, int from, int to, Real limit) {
    return largest_component(t.corner[from].end - t.corner[to].end) < limit;
  }
};

}  // namespace collided
