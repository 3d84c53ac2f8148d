#pragma once
// Whether an edge crosses a triangle at rest, decided exactly. Host only, like exact.hpp; on any backend:
// fixed/edge_triangle.hpp.

#include <cstdint>

#include "gpu/base/vec3.hpp"

namespace collided {

/// The relation of an edge u v and a triangle a b c that share no vertex.
struct EdgeTriangleVerdict {
  /// True if, with ties broken by the vertices' ids, u and v are on different sides of the triangle's plane and the
  /// line through them passes the triangle's three sides alike. Implies `meets`.
  bool crosses = false;
  bool touches = false;  ///< they meet, but a determinant that decides it is 0: `crosses` follows from the ids' order
  bool meets = false;    ///< the closed edge and the closed triangle have a common point; independent of ids
  bool from_front =
      false;  ///< if it crosses: u is on the side that the normal (b - a) x (c - a) points to, ties broken
  /// Where they meet: the position on the edge, 0 at u to 1 at v, and the point's weights of b and c, each in [0, 1]
  /// and their sum at most 1; the weight of a is the rest. In one plane it is the middle of what they share. Within
  /// 2^-49.
  double along = 0;
  double weights[2] = {};
};

/// `points` holds u v a b c: any finite coordinates, denormals included. `ids` are their scene-wide ids, all different;
/// only their order matters. Edges without length and triangles without area are ordinary input.
EdgeTriangleVerdict exact_edge_triangle(const Vec3<double> (&points)[5], const uint32_t (&ids)[5]);

}  // namespace collided
