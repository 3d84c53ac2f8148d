#pragma once
// CCD at the levels GUARDED (Work = float), CERTIFIED and EXACT (Work = double): no contact of the given positions is
// missed, and no time of impact is late.

#include "gpu/narrow/certificate.hpp"

namespace collided {

/// Tolerance in units of the query's extent where none is given: what a few more iterations cannot improve.
COLLIDED_HD inline float default_delta(float) { return 0x1p-20f; }
COLLIDED_HD inline double default_delta(double) { return 0x1p-48; }

/// The contact's data at time t, as far as the features' differences tell.
template <class Real, class Work, int N>
COLLIDED_HD ContactData<Real> contact_at(const Differences<Work, N>& d, Work t, uint8_t flags) {
  Vec3<Work> x[N];
  differences_at(d, t, x);
  const Closest<Work> points = closest_points(x);
  const Vec3<Work> vector = between_points(x, points.w0, points.w1);
  const double distance = static_cast<double>(std::sqrt(dot(vector, vector))) / d.scale;
  return {static_cast<double>(t), static_cast<Real>(distance), static_cast<Real>(points.w0),
          static_cast<Real>(points.w1), flags};
}

template <class Work, class Real, class Kind>
struct AdvanceCcd {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  double thickness, delta;
  Kind kind;
  Span<const uint64_t> candidates;
  Hurry hurry;
  ContactList<Real> contacts;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (hurry.is_over()) return;
    DifferencesOf<Work, Kind> d;
    if (!load_differences<Kind, Work>(kind.stencil(candidates[i]), start, end, d)) return report_coincident(i);
    const Tolerance<Work> tolerance{scaled_thickness<Work>(thickness, d.scale),
                                    delta > 0 ? static_cast<Work>(delta * d.scale) : default_delta(Work(0)) * d.extent};
    const Advance<Work> found = advance(d, tolerance, static_cast<Work>(hurry.last()));
    if (!found.hit) return;
    report(i, contact_at<Real>(d, found.t, flags_of(d, found, tolerance.thickness)));
  }

 private:
  COLLIDED_HD static uint8_t flags_of(const DifferencesOf<Work, Kind>& d, const Advance<Work>& found, Work scaled) {
    const bool is_sure = is_certain(d, found.t, scaled);
    uint8_t flags = is_sure ? kFlagCertified : kFlagNear;
    if (found.capped) flags |= kFlagCapped;
    // A sure contact may come after its lower bound 0.
    if (found.t == 0 && (!is_sure || touches_at(d, Work(0), scaled))) flags |= kFlagInitial;
    return flags;
  }
  COLLIDED_HD void report_coincident(uint64_t i) const {
    report(i, {0, Real(0), Real(0), Real(0), uint8_t{kFlagCertified | kFlagInitial}});
  }
  COLLIDED_HD void report(uint64_t i, const ContactData<Real>& contact) const {
    contacts.push(candidates[i], contact);
    hurry.found(contact.toi, contact.flags);
  }
};

}  // namespace collided
