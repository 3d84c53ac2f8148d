#include "gpu/exact/exact.hpp"

#include "gpu/exact/features.hpp"

namespace collided {

ExactImpact exact_ccd(ContactKind kind, const Vec3<double> (&start)[4], const Vec3<double> (&end)[4],
                      double thickness) {
  return exact::first_impact(exact::contact_of(kind, exact::in_motion(start, end, thickness)));
}

bool exact_proximity(ContactKind kind, const Vec3<double> (&p)[4], double thickness) {
  return exact::holds_at_start(exact::contact_of(kind, exact::at_rest(p, thickness)));
}

}  // namespace collided
