#pragma once
// Two triangles of one frame by the differences of their corners, and planes that part what these differences are of.

#include "gpu/narrow/certificate.hpp"

namespace collided {

/// Differences a_i - b_j of the vertices of two triangles, scaled as in Differences.
template <class Work>
struct TriangleDifferences {
  Vec3<Work> d[3][3];
  Work extent;
};

/// False if all six vertices coincide.
template <class Work, class Real>
COLLIDED_HD bool load_differences(const Vec3<uint32_t>& a, const Vec3<uint32_t>& b, const Vec3<Real>* positions,
                                  TriangleDifferences<Work>& out) {
  using Wide = Wider<Work, Real>;
  const uint32_t first[3] = {a.x, a.y, a.z}, second[3] = {b.x, b.y, b.z};
  Vec3<Wide> d[3][3];
  Wide extent = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      d[i][j] = convert<Wide>(positions[first[i]]) - convert<Wide>(positions[second[j]]);
      extent = max(extent, largest_component(d[i][j]));
    }
  if (extent == 0) return false;
  const Wide scale = unit_scale(extent);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out.d[i][j] = convert<Work>(scale * d[i][j]);
  out.extent = static_cast<Work>(scale * extent);
  return true;
}

/// True if a plane across the axis is certain to part n points from the corners of a triangle, from which they are at
/// d.
template <class Work, int n>
COLLIDED_HD bool separates(const Vec3<Work> (&d)[n][3], const Vec3<Work>& axis) {
  const Direction<Work> direction = direction_of(axis);
  if (direction.length == 0) return false;
  bool above = true, below = true;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 3; ++j) {
      above = above && lower_bound_along(direction.n, d[i][j], Work(0)) > 0;
      below = below && lower_bound_along(Work(-1) * direction.n, d[i][j], Work(0)) > 0;
    }
  return above || below;
}

}  // namespace collided
