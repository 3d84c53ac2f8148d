#pragma once
// What is not known of a pair of features: how much closer they may be than the straight paths of their positions. It
// adds to the thickness, so that nothing is missed, and takes from what makes a contact certain.

#include "gpu/base/half_thickness.hpp"
#include "gpu/contacts/contact.hpp"

namespace collided {

struct Doubt {
  double encoding;        ///< of every pair: its positions were encoded
  Deviations deviations;  ///< meshes that turn

  template <class Kind>
  COLLIDED_HD double of(const Kind& kind, uint64_t key) const {
    if (!deviations.is_needed()) return encoding;
    const Stencil s = kind.stencil(key);
    return Deviations::widened(encoding, deviations.of_pair(s.v[0], s.v[3]));
  }
};

/// Returns the contact distance of a pair of features in a scene of that thickness.
template <class Kind>
COLLIDED_HD ContactDistance distance_of(const HalfThicknesses& halves, double thickness, const Kind& kind,
                                        uint64_t key) {
  if (!halves.is_needed()) return thickness;
  const Stencil s = kind.stencil(key);
  return halves.of_pair(thickness, s.v[0], s.v[3]);
}

/// Returns a distance that no contact's positions exceed.
COLLIDED_HD inline double doubtful_distance(const ContactDistance& distance, double doubt) {
  return Deviations::widened(distance.above(), doubt);
}
/// Returns the distance that positions must be within for the features to be in contact for certain; 0: there is none.
COLLIDED_HD inline double certain_distance(const ContactDistance& distance, double doubt) {
  const double thickness = distance.below();
  return doubt == 0 ? thickness : thickness > doubt ? next_down(thickness - doubt) : 0;
}

}  // namespace collided
