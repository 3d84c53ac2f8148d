#pragma once
// EXACT without thickness: most contacts are decided where they are, and get the time of impact that exact arithmetic
// gives: what is simple in numbers of twice double's precision, what is not in integers of fixed size. The host decides
// what is left, and drops what is no contact.

#include "gpu/contacts/kinds.hpp"
#include "gpu/exact/fixed/decide.hpp"

namespace collided {

/// The contacts of features in a list.
template <class Real>
struct DecidedContacts {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  bool is_ccd;
  FeatureKinds kinds;
  FeatureRanks ranks;
  Span<const uint64_t> keys;
  Span<ContactData<Real>> data;
  uint64_t* decisions;  ///< that floating point left open

  COLLIDED_HD bool is_open(const ContactData<Real>& contact) const {
    return is_undecided(contact.flags, is_ccd && contact.toi == 0);
  }
  /// use(kind, from, to): the features' points.
  template <class Use>
  COLLIDED_HD void use_points(uint64_t i, const Use& use) const {
    use_contact(kinds, ranks, keys[i], [&](const auto& kind, uint64_t key) {
      const FeaturePoints<Real> points = points_of(kind.stencil(key), start, end);
      Vec3<double> from[4], to[4];
      for (int k = 0; k < 4; ++k) from[k] = convert<double>(points.start[k]), to[k] = convert<double>(points.end[k]);
      use(kind, from, to);
    });
  }
  COLLIDED_HD void decide(ContactData<Real>& contact, const exact::fixed::Verdict& verdict) const {
    if (is_open(contact)) atomic_add(*decisions, uint64_t{1});
    const bool is_initial = is_ccd && verdict.outcome == exact::fixed::Outcome::kAtStart;
    contact.flags = decided_flags(contact.flags, is_initial);
    contact.toi = is_ccd ? verdict.toi : 0;
  }
};

/// Decides contacts that come soon after their times of impact, which are early; leaves the others in the list of their
/// kind. Contacts on arcs are left as they are.
template <class Real>
struct DecideSoon {
  DecidedContacts<Real> contacts;
  AppendList<uint64_t> others[kFeatureKinds];

  COLLIDED_HD void operator()(uint64_t i) const {
    ContactData<Real>& contact = contacts.data[i];
    if (!contacts.is_ccd && !contacts.is_open(contact)) return;
    if ((contact.flags & kFlagOnArc) != 0) return;
    contacts.use_points(i, [&]<class Kind>(const Kind&, const auto& from, const auto& to) {
      exact::fixed::Verdict verdict;
      if (contacts.is_ccd && contact.toi > 0) verdict = exact::fixed::decide_soon<Kind::kKind>(from, to, contact.toi);
      if (verdict.outcome == exact::fixed::Outcome::kOpen)
        others[kIndexOf<Kind>].push(i);
      else
        contacts.decide(contact, verdict);
    });
  }
};

/// Decides the others. Each takes a warp of a GPU by itself, where there are few: no two go the same way.
template <class Real, class Kind>
struct DecideOther {
  /// A decision is one step.
  struct State {
    COLLIDED_HD bool is_over() const { return true; }
  };
  DecidedContacts<Real> contacts;
  Span<const uint64_t> others;
  uint64_t* undecided;  ///< contacts that are left to the host, if only to be dropped

  COLLIDED_HD void begin(uint64_t i, State&) const {
    ContactData<Real>& contact = contacts.data[others[i]];
    contacts.use_points(others[i], [&](const auto&, const auto& from, const auto& to) {
      const exact::fixed::Verdict verdict = verdict_of(from, to, contact.toi);
      if (verdict.outcome > exact::fixed::Outcome::kApart) return contacts.decide(contact, verdict);
      atomic_add(*contacts.decisions, uint64_t{1});
      atomic_add(*undecided, uint64_t{1});
      const uint8_t known = verdict.outcome == exact::fixed::Outcome::kApart ? kFlagApart : uint8_t{0};
      contact.flags = static_cast<uint8_t>((contact.flags & ~kFlagCertified) | kFlagNear | known);
    });
  }
  COLLIDED_HD void step(State&) const {}
  COLLIDED_HD void finish(State&) const {}

 private:
  COLLIDED_HD exact::fixed::Verdict verdict_of(const Vec3<double> (&from)[4], const Vec3<double> (&to)[4],
                                               double toi) const {
    if (contacts.is_ccd) return exact::fixed::decide_from<Kind::kKind>(from, to, toi);
    return {exact::fixed::decide_at_rest<Kind::kKind>(to), 0};
  }
};

}  // namespace collided
