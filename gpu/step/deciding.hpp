#pragma once
// EXACT without thickness: most contacts are decided where they are, in integers of fixed size, and get the time of
// impact that exact arithmetic gives. The host decides what is left, and drops what is no contact.

#include "gpu/contacts/kinds.hpp"
#include "gpu/exact/fixed/decide.hpp"

namespace collided {

/// The contacts of features in a list.
template <class Real>
struct DecideContacts {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  bool is_ccd;
  FeatureKinds kinds;
  FeatureRanks ranks;
  Span<const uint64_t> keys;
  Span<ContactData<Real>> data;
  uint64_t* decisions;  ///< that floating point left open
  uint64_t* undecided;  ///< contacts that are left to the host

  COLLIDED_HD void operator()(uint64_t i) const {
    use_contact(kinds, ranks, keys[i],
                [&](const auto& kind, uint64_t key) { decide(kind, kind.stencil(key), data[i]); });
  }

 private:
  template <class Kind>
  COLLIDED_HD void decide(const Kind&, const Stencil& stencil, ContactData<Real>& contact) const {
    const bool is_open = is_undecided(contact.flags, is_ccd && contact.toi == 0);
    if (!is_open && !is_ccd) return;
    const exact::fixed::Verdict verdict = verdict_of<Kind>(points_of(stencil, start, end));
    const bool is_decided = verdict.outcome > exact::fixed::Outcome::kApart;
    if (is_open || !is_decided) atomic_add(*decisions, uint64_t{1});
    if (!is_decided) {
      atomic_add(*undecided, uint64_t{1});
      contact.flags = static_cast<uint8_t>((contact.flags & ~kFlagCertified) | kFlagNear);
      return;
    }
    const bool is_initial = is_ccd && verdict.outcome == exact::fixed::Outcome::kAtStart;
    contact.flags = decided_flags(contact.flags, is_initial);
    contact.toi = is_ccd ? verdict.toi : 0;
  }
  template <class Kind>
  COLLIDED_HD exact::fixed::Verdict verdict_of(const FeaturePoints<Real>& points) const {
    Vec3<double> from[4], to[4];
    for (int k = 0; k < 4; ++k) from[k] = convert<double>(points.start[k]), to[k] = convert<double>(points.end[k]);
    if (is_ccd) return exact::fixed::decide<Kind::kKind>(from, to);
    return {exact::fixed::decide_at_rest<Kind::kKind>(to), 0};
  }
};

}  // namespace collided
