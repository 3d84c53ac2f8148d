#pragma once
// Doubles as integers: all of a query's numbers times one power of two. The decisions do not depend on the unit.

#include <array>

#include "gpu/base/contact_distance.hpp"
#include "gpu/base/vec3.hpp"
#include "gpu/exact/form.hpp"

namespace collided::exact {

/// A query's numbers as forms of one degree: 0 at rest, 1 in motion.
template <class Linear>
struct QueryOf {
  std::array<Vec3<Linear>, 4> points;
  Linear limit;  ///< the contact distance
};
using ExactQuery = QueryOf<Form>;

ExactQuery at_rest(const Vec3<double> (&points)[4], const ContactDistance& limit);
ExactQuery in_motion(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], const ContactDistance& limit);

}  // namespace collided::exact
