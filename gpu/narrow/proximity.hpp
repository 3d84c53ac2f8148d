#pragma once
// DCD: features of one frame that are at most the contact distance apart. Level FAST: working precision, no guarantee.

#include "gpu/base/half_thickness.hpp"
#include "gpu/narrow/features.hpp"

namespace collided {

template <class Real, class Kind>
struct TestProximity {
  const Vec3<Real>* positions;
  double thickness;
  Kind kind;
  Span<const uint64_t> candidates;
  ContactSink<Real> contacts;
  HalfThicknesses halves = {};

  COLLIDED_HD void operator()(uint64_t i) const {
    if (contacts.early_exit.is_over()) return;
    const Stencil s = kind.stencil(candidates[i]);
    // Differences to one vertex keep digits that coordinates far from the origin would waste.
    const Vec3<Real> o = positions[s.v[0]];
    const Vec3<Real> p[4] = {o - o, positions[s.v[1]] - o, positions[s.v[2]] - o, positions[s.v[3]] - o};
    const Closest<Real> found = closest(kind, p);
    const Real distance = std::sqrt(found.squared);
    const Real limit = static_cast<Real>(halves.of_pair(thickness, s.v[0], s.v[3]).nearly());
    if (distance <= limit) contacts.report(candidates[i], {0, distance, found.w0, found.w1, 0});
  }
};

}  // namespace collided
