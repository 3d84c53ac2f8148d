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

/// Triangles that are nowhere longer than the limit. Their boxes would not tell: these are rounded outward to float.
template <class Real>
struct IsSmall {
  const Vec3<Real>* positions;
  Span<const Triangle> triangles;
  Real limit;

  COLLIDED_HD uint64_t operator()(uint64_t i) const {
    const Triangle t = triangles[i];
    const Vec3<Real> a = positions[t.x], b = positions[t.y], c = positions[t.z];
    return is_short(a - b) && is_short(b - c) && is_short(c - a) ? 1 : 0;
  }

 private:
  COLLIDED_HD bool is_short(const Vec3<Real>& edge) const { return largest_component(edge) < limit; }
};

}  // namespace collided
