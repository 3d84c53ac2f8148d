#pragma once
// When a vertex and a triangle, or two edges, are within a contact distance of each other, as signs of polynomials.

#include "gpu/exact/contact.hpp"

namespace collided::exact {

/// Points v, a, b, c or a0, a1, b0, b1 that move linearly. Takes the least time where all numbers fit integers of fixed
/// size.
Contact contact_in_motion(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                          const ContactDistance& limit);
/// Returns the same, from numbers that may have any exponents.
Contact contact_in_any_size(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                            const ContactDistance& limit);
/// The same for points at rest, in forms of degree 0.
Contact contact_at_rest(ContactKind kind, const Vec3<double> (&p)[4], const ContactDistance& limit);

}  // namespace collided::exact
