#pragma once
// How fine the positions are, compared with the scene's triangles.

#include "gpu/broad/boxes.hpp"

namespace collided {

/// Distance of neighbouring numbers at the largest coordinate in the bounds.
template <class Real>
Real spacing_at(const Box<float>& bounds) {
  constexpr float kMost = std::numeric_limits<float>::max();
  const float m = smaller(larger(largest_component(bounds.lo), largest_component(bounds.hi)), kMost);
  const Real at = static_cast<Real>(m);
  return at - next_down(at);
}

/// Triangles whose boxes are nowhere longer than the limit.
struct IsSmall {
  Span<const Box<float>> boxes;
  float limit;

  COLLIDED_HD uint64_t operator()(uint64_t i) const {
    return largest_component(boxes[i].hi - boxes[i].lo) < limit ? 1 : 0;
  }
};

}  // namespace collided
