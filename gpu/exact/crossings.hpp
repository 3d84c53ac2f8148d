#pragma once
// Decides exactly whether an edge crosses a triangle at rest. It runs on the host, as the functions of exact.hpp do;
// decide_edge_triangle() runs on any backend.

#include "gpu/exact/fixed/edge_triangle.hpp"

namespace collided {

/// Decides for `points` u v a b c, with any finite coordinates, denormals included. Edges without length and triangles
/// without area are ordinary input. `ids` are the points' scene-wide ids. They are all different, and only their order
/// matters.
EdgeTriangleVerdict exact_edge_triangle(const Vec3<double> (&points)[5], const uint32_t (&ids)[5]);

}  // namespace collided
