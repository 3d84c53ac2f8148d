#pragma once
// When a vertex and a triangle, or two edges, are within the thickness of each other, as signs of polynomials.

#include "gpu/exact/contact.hpp"
#include "gpu/exact/integers.hpp"

namespace collided::exact {

/// Points v, a, b, c or a0, a1, b0, b1.
Contact contact_of(ContactKind kind, const ExactQuery& query);

/// Returns the same for points that move linearly, and takes less time where all numbers fit integers of fixed size.
Contact contact_in_motion(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                          double thickness);

}  // namespace collided::exact
