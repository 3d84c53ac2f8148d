#pragma once
// Decides exactly whether the ray from a vertex in the direction of z crosses a triangle. It runs on the host, as the
// functions of exact.hpp do; decide_ray() runs on any backend.

#include "gpu/exact/fixed/ray_triangle.hpp"

namespace collided {

/// Decides for `points` v a b c, with any finite coordinates, denormals included. Triangles without area are ordinary
/// input. `ids` are the points' scene-wide ids. They are all different, and only their order matters.
RayVerdict exact_ray(const Vec3<double> (&points)[4], const uint32_t (&ids)[4]);

}  // namespace collided
