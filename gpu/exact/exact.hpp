#pragma once
// Exact decisions: what real arithmetic says of the given doubles. Any finite coordinates, denormals included; host
// only; no state, so any number of threads may call at once. Degenerate features (zero-length edges, zero-area
// triangles, coplanar and parallel motion) are ordinary input.

#include "gpu/base/contact_distance.hpp"
#include "gpu/base/vec3.hpp"
#include "gpu/contact_set.hpp"

namespace collided {

/// Whether and when features that move linearly meet, decided as in real arithmetic.
struct ExactImpact {
  bool hit = false;
  /// Time of the first contact in [0, 1], rounded down to a multiple of 2^-60 and then to a double; 1 if no hit.
  double toi = 1;
  bool initial = false;  ///< in contact at t = 0
};

/// Vertex v against triangle a b c, or edge a0 a1 against edge b0 b1; `start` and `end` hold v a b c, or a0 a1 b0 b1,
/// at t = 0 and at t = 1. A hit is a distance <= `limit` at some t in [0, 1], both ends included. The limit is in the
/// unit of the coordinates. Not for triangle pairs.
ExactImpact exact_ccd(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                      const ContactDistance& limit);

/// The same features at rest, at p: whether their distance is <= `limit`.
bool exact_proximity(ContactKind kind, const Vec3<double> (&p)[4], const ContactDistance& limit);

/// The closed triangles have a point in common; coplanar triangles and triangles without area included.
bool exact_triangles_intersect(const Vec3<double> (&a)[3], const Vec3<double> (&b)[3]);

/// The first corners of the triangles are one vertex: the closed side opposite to it of one meets the other closed
/// triangle. If both have area, they then have a point in common that is not that corner, and only then.
bool exact_triangles_meet_beyond_corner(const Vec3<double> (&a)[3], const Vec3<double> (&b)[3]);

}  // namespace collided
