#pragma once
// Exact decisions: what real arithmetic says of the given doubles. Any finite coordinates, denormals included; host
// only; no state, so any number of threads may call at once. Degenerate features (zero-length edges, zero-area
// triangles, coplanar and parallel motion) are ordinary input.

#include "gpu/base/vec3.hpp"

namespace collided {

/// Whether and when features that move linearly meet, decided as in real arithmetic.
struct ExactImpact {
  bool hit = false;
  /// Time of the first contact in [0, 1], rounded down to a multiple of 2^-60 and then to a double; 1 if no hit.
  double toi = 1;
};

/// Vertex v against triangle a b c; `start` and `end` hold v, a, b, c at t = 0 and at t = 1. A hit is a distance
/// <= thickness at some t in [0, 1], both ends included. thickness >= 0, in the unit of the coordinates.
ExactImpact exact_ccd_vertex_triangle(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], double thickness);

/// Edge a0 a1 against edge b0 b1; `start` and `end` hold a0, a1, b0, b1. Else as for a vertex and a triangle.
ExactImpact exact_ccd_edge_edge(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], double thickness);

/// Vertex p[0] and triangle p[1] p[2] p[3] have a distance <= thickness.
bool exact_proximity_vertex_triangle(const Vec3<double> (&p)[4], double thickness);

/// Edge p[0] p[1] and edge p[2] p[3] have a distance <= thickness.
bool exact_proximity_edge_edge(const Vec3<double> (&p)[4], double thickness);

/// The closed triangles have a point in common; coplanar triangles and triangles without area included.
bool exact_triangles_intersect(const Vec3<double> (&a)[3], const Vec3<double> (&b)[3]);

}  // namespace collided
