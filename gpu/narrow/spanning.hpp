#pragma once
// Coplanarity of a candidate's four vertices.

#include "gpu/contacts/contact.hpp"

namespace collided {

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
