#pragma once
// Points that only the host can decide about.

#include "gpu/solids/nearest.hpp"

namespace collided {

/// Writes the vertex and the triangle's corners of each rival, four points each.
template <class Real>
struct GatherRivals {
  SolidTree<Real> tree;
  Span<const uint64_t> inside;
  Span<const Rival> rivals;
  Span<Vec3<Real>> points;

  COLLIDED_HD void operator()(uint64_t k) const {
    const Vec3<uint32_t> corners = tree.triangles[rivals[k].place].corners;
    const uint32_t of[4] = {first_id(inside[rivals[k].pair]), corners.x, corners.y, corners.z};
    for (int i = 0; i < 4; ++i) points[4 * k + i] = tree.positions[of[i]];
  }
};

}  // namespace collided
