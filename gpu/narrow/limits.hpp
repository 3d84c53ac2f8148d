#pragma once
// Pairs that limit a way, as contacts: a solver can take them as constraints. Such a pair would break its floors
// (floors.hpp) if all went the whole way.

#include "gpu/narrow/bent_ways.hpp"
#include "gpu/narrow/certified_ccd.hpp"
#include "gpu/narrow/floors.hpp"
#include "gpu/narrow/normal.hpp"

namespace collided {

namespace detail {

/// Returns the flags of a pair that is farther apart than its floor until t. It is off its straight way by `off` at
/// most.
template <int N>
COLLIDED_HD uint8_t flags_of_limit(const Differences<double, N>& d, double t, const PairFloors& floors, double off) {
  const double thickness = scaled_thickness<double>(certain_distance(floors.kept, off), d.scale);
  const bool is_sure = thickness > 0 && certain_by(d, t, thickness) < kNeverCertain;
  const bool is_initial = t == 0 && (!is_sure || touches_at(d, 0.0, thickness));
  return static_cast<uint8_t>((is_sure ? kFlagCertified : kFlagNear) | (is_initial ? kFlagInitial : 0));
}

}  // namespace detail

/// Returns a pair that breaks its floors on the whole way as a contact. Its time is that until which the pair is
/// certain to be farther apart than its floor, 0 for tiny pairs; its distance is the floor. Weights are those of
/// straight ways at that time.
template <class Kind, class Real>
COLLIDED_LONG COLLIDED_HD ContactData<double> limit_of(const FeaturePoints<Real>& way, const PairFloors& floors,
                                                       const PairTurn& turn) {
  constexpr uint8_t kAtStart = kFlagNear | kFlagInitial;
  DifferencesOf<double, Kind> d;
  if (!load_differences<Kind, double>(way, d)) return {0, floors.kept, 0, 0, kAtStart};
  ContactData<double> limit;
  if (floors.is_tiny) {
    limit = contact_at<double>(d, 0.0, kAtStart);
  } else {
    const auto bent = bent_way<Kind>(way, d, turn);
    const double t = min(certified_way(bent.d, Deviations::widened(floors.kept, bent.off)).until, 1.0);
    limit = contact_at<double>(d, t, detail::flags_of_limit(bent.d, t, floors, bent.off));
  }
  limit.distance = floors.kept;
  return limit;
}

}  // namespace collided
