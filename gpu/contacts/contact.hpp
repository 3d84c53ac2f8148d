#pragma once
// What the narrow phase writes, and how it reads a candidate's four vertices.

#include "gpu/base/box.hpp"
#include "gpu/base/points.hpp"
#include "gpu/exec/atomic.hpp"
#include "gpu/types.hpp"

namespace collided {

template <class Real>
struct ContactData {
  double toi;
  Real distance;
  Real w0, w1;
  uint8_t flags;
};

// At kExact. `is_at_zero`: the contact has a time of impact, which is 0.

/// Marks a pair one of whose meshes turns: what exact arithmetic says of straight paths does not hold for it. No answer
/// has the mark.
constexpr uint8_t kFlagOnArc = 64;

/// Whether only exact arithmetic can decide a contact: it is not certain, its time was left far off by the limit of
/// iterations, or is 0 though the features may not touch at the start.
COLLIDED_HD inline bool is_undecided(uint8_t flags, bool is_at_zero) {
  if ((flags & kFlagOnArc) != 0) return false;
  return (flags & (kFlagCertified | kFlagCapped)) != kFlagCertified || (is_at_zero && (flags & kFlagInitial) == 0);
}
/// A pair that the step itself has decided to be apart; the host drops it, so the flag is in no answer.
constexpr uint8_t kFlagApart = 128;
/// Those of a contact that exact arithmetic has decided.
COLLIDED_HD inline uint8_t decided_flags(uint8_t before, bool is_initial) {
  return static_cast<uint8_t>(kFlagCertified | (is_initial ? kFlagInitial : 0) | (before & kFlagSeparating));
}

/// Contacts in two lists that share their slots: keys to sort by, and the rest.
template <class Real>
struct ContactList {
  AppendList<uint64_t> keys;
  Span<ContactData<Real>> data;

  COLLIDED_HD void push(uint64_t key, const ContactData<Real>& contact) const {
    const uint64_t slot = claim_slot(*keys.count);
    if (slot >= keys.items.size()) return;
    keys.items[slot] = key;
    data[slot] = contact;
  }
};

/// Four vertex ids of a candidate.
struct Stencil {
  uint32_t v[4];
};

template <class Real>
COLLIDED_HD FeaturePoints<Real> points_of(const Stencil& s, const Vec3<Real>* start, const Vec3<Real>* end) {
  FeaturePoints<Real> points;
  for (int k = 0; k < 4; ++k) points.start[k] = start[s.v[k]], points.end[k] = end[s.v[k]];
  return points;
}

/// What the queries of a frame know of each other, so that those that no longer matter end early.
struct Shortcut {
  uint64_t earliest_bits;  ///< of the earliest time of a contact that counts; doubles >= 0 order like their bits
  uint32_t has_contact;    ///< whether there is a contact that counts
};

/// How the queries of a frame use it. Which queries end early depends on their order; the earliest time does not: a
/// query ends only when its contact is certain to be later than one that was found.
struct EarlyExit {
  Shortcut* shortcut = nullptr;  ///< null: every contact is wanted
  Report report = Report::kAll;
  bool only_certain = false;  ///< only certain contacts count, by when they are; the rest is decided later

  COLLIDED_HD bool is_over() const { return report == Report::kAnyHit && atomic_read(shortcut->has_contact) != 0; }
  /// Contacts after this time do not matter.
  COLLIDED_HD double last() const {
    if (report != Report::kEarliestOnly) return 1;
    return detail::bit_copy<double>(atomic_read(shortcut->earliest_bits));
  }
  /// `by`: a time at which the features have met, if that is certain.
  COLLIDED_HD void found(double toi, double by, uint8_t flags) const {
    if (report == Report::kAll || (only_certain && (flags & kFlagCertified) == 0)) return;
    if (report == Report::kAnyHit) atomic_write(shortcut->has_contact, uint32_t{1});
    if (report == Report::kEarliestOnly)
      atomic_min(shortcut->earliest_bits, detail::bit_copy<uint64_t>(only_certain ? by : toi));
  }
};

/// Where a query tells of its contact: the list, and the other queries of the frame. All kinds share the list, in the
/// order of their first features' ranks: those of vertices, of edges, of triangles.
template <class Real>
struct ContactSink {
  ContactList<Real> list;
  EarlyExit early_exit;
  uint32_t first_rank;  ///< of the kind's first features

  COLLIDED_HD void report(uint64_t key, const ContactData<Real>& contact) const { report(key, contact, contact.toi); }
  COLLIDED_HD void report(uint64_t key, const ContactData<Real>& contact, double by) const {
    list.push(key + (uint64_t{first_rank} << 32), contact);
    early_exit.found(contact.toi, by, contact.flags);
  }
};

}  // namespace collided
