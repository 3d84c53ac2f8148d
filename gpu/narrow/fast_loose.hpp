#pragma once
// CCD at level FAST of a vertex and a loose edge or point (search/loose_elements.hpp): their four vertices are coplanar
// at all times, so that no cubic tells when they meet. They are followed as from GUARDED on, in the precision of the
// positions, until they are within reach.

#include "gpu/narrow/certified_ccd.hpp"
#include "gpu/narrow/fast_ccd.hpp"

namespace collided {

/// The candidates that SolveCubicCcd leaves.
template <class Real>
struct FollowLooseCcd {
  using State = CcdState<Real, VertexTriangle>;
  CcdQueries<Real, VertexTriangle, uint64_t> queries;
  ContactSink<Real> contacts;

  COLLIDED_HD void begin(uint64_t i, State& state) const {
    state.key = queries.key(i);
    if (contacts.early_exit.is_over() || !is_always_coplanar(queries.kind.stencil(state.key))) return;
    DifferencesOf<Real, VertexTriangle>& d = state.features.d;
    if (!queries.load(i, d)) return contacts.report(state.key, {0, Real(0), Real(0), Real(0), kFlagInitial});
    const Real thickness = scaled_thickness<Real>(queries.distance_of(state.key).above(), d.scale);
    const Real reach = proximity_tolerance(Real(0)) * d.extent;
    state.features.begin({{thickness, thickness}, reach}, {}, kMaxIterations);
  }
  COLLIDED_HD void step(State& state) const { state.features.iterate(Real(1)); }
  COLLIDED_HD void finish(const State& state) const {
    if (!state.features.is_hit()) return;
    const Real t = state.features.time();
    contacts.report(state.key, contact_at<Real>(state.features.d, t, t == 0 ? uint8_t{kFlagInitial} : uint8_t{0}));
  }
};

}  // namespace collided
