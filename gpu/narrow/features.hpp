#pragma once
// What the narrow phase has to know of each kind of features: the differences of their vertices that tell everything
// else, their closest points, and when they are coplanar. Its other headers treat all kinds alike.

#include "gpu/contacts/kinds.hpp"
#include "gpu/narrow/distance.hpp"

namespace collided {

/// Which vertices of the stencil the k-th difference takes.
template <class Kind>
struct DifferenceOf;
/// v - a, v - b, v - c.
template <>
struct DifferenceOf<VertexTriangle> {
  static constexpr int kCount = 3;
  static constexpr int kOfFirst = 1;  ///< the first of the four vertices are the first feature's
  COLLIDED_HD static constexpr int minuend(int) { return 0; }
  COLLIDED_HD static constexpr int subtrahend(int k) { return k + 1; }
};
/// a0 - b0, a0 - b1, a1 - b0, a1 - b1.
template <>
struct DifferenceOf<EdgeEdge> {
  static constexpr int kCount = 4;
  static constexpr int kOfFirst = 2;
  COLLIDED_HD static constexpr int minuend(int k) { return k / 2; }
  COLLIDED_HD static constexpr int subtrahend(int k) { return 2 + k % 2; }
};

/// The convex combination of the differences that the weights of two points give: the vector from the second
/// feature's point to the first's. Weights as in Closest.
template <class Work>
COLLIDED_HD Vec3<Work> between_points(const Vec3<Work> (&d)[3], Work w0, Work w1) {
  return max(1 - w0 - w1, Work(0)) * d[0] + w0 * d[1] + w1 * d[2];
}
template <class Work>
COLLIDED_HD Vec3<Work> between_points(const Vec3<Work> (&d)[4], Work w0, Work w1) {
  return (1 - w0) * ((1 - w1) * d[0] + w1 * d[1]) + w0 * ((1 - w1) * d[2] + w1 * d[3]);
}

/// Weights of the closest points, each in [0, 1]; working precision.
template <class Work>
COLLIDED_HD Closest<Work> closest_points(const Vec3<Work> (&d)[3]) {
  return closest_vertex_triangle(d[0], Vec3<Work>{0, 0, 0}, d[0] - d[1], d[0] - d[2]);
}
template <class Work>
COLLIDED_HD Closest<Work> closest_points(const Vec3<Work> (&d)[4]) {
  // b0 at the origin: a0 = d[0], a1 = d[2], b1 = d[0] - d[1].
  return closest_edge_edge(d[0], d[2], Vec3<Work>{0, 0, 0}, d[0] - d[1]);
}

/// As closest_points, with the features' common normal, in fewer operations: for directions, not for reports.
template <class Work>
COLLIDED_HD Weights<Work> nearly_closest_points(const Vec3<Work> (&d)[3], const Vec3<Work>& normal) {
  return nearly_closest_vertex_triangle(d[0], d[0] - d[1], d[0] - d[2], normal);
}
template <class Work>
COLLIDED_HD Weights<Work> nearly_closest_points(const Vec3<Work> (&d)[4], const Vec3<Work>& normal) {
  return nearly_closest_edge_edge(d[0], d[2] - d[0], d[0] - d[1], normal);
}

/// Two edges that span the triangle, or both edges.
template <class Work>
struct SpanningEdges {
  Vec3<Work> first, second;
};
template <class Work>
COLLIDED_HD SpanningEdges<Work> spanning_edges(const Vec3<Work> (&d)[3]) {
  return {d[0] - d[1], d[0] - d[2]};
}
template <class Work>
COLLIDED_HD SpanningEdges<Work> spanning_edges(const Vec3<Work> (&d)[4]) {
  return {d[2] - d[0], d[0] - d[1]};
}

/// Closest points of the features with these vertices.
template <class Real>
COLLIDED_HD Closest<Real> closest(const VertexTriangle&, const Vec3<Real> (&p)[4]) {
  return closest_vertex_triangle(p[0], p[1], p[2], p[3]);
}
template <class Real>
COLLIDED_HD Closest<Real> closest(const EdgeEdge&, const Vec3<Real> (&p)[4]) {
  return closest_edge_edge(p[0], p[1], p[2], p[3]);
}

/// The three vectors whose determinant vanishes when the four vertices are coplanar.
template <class Real>
COLLIDED_HD void spanning_vectors(const VertexTriangle&, const Vec3<Real> (&p)[4], Vec3<Real> (&out)[3]) {
  out[0] = p[2] - p[1], out[1] = p[3] - p[1], out[2] = p[0] - p[1];
}
template <class Real>
COLLIDED_HD void spanning_vectors(const EdgeEdge&, const Vec3<Real> (&p)[4], Vec3<Real> (&out)[3]) {
  out[0] = p[1] - p[0], out[1] = p[3] - p[2], out[2] = p[2] - p[0];
}

}  // namespace collided
