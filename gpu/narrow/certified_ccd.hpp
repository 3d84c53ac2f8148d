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
  const Gap<Work> gap = gap_at(d, t);
  const double distance = static_cast<double>(gap.length) / d.scale;
  return {static_cast<double>(t), static_cast<Real>(distance), static_cast<Real>(gap.points.w0),
          static_cast<Real>(gap.points.w1), flags};
}

/// Keeps the candidates that float cannot tell apart in a few iterations: a cheap filter in front of double precision.
template <class Real, class Kind>
struct ScreenCcd {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  double thickness, delta;
  Kind kind;
  Span<const uint64_t> candidates;
  AppendList<uint64_t> survivors;

  COLLIDED_HD void operator()(uint64_t i) const {
    DifferencesOf<float, Kind> d;
    const bool differ = load_differences<Kind, float>(points_of(kind.stencil(candidates[i]), start, end), d);
    if (!differ || !is_free(d)) survivors.push(candidates[i]);
  }

 private:
  COLLIDED_HD bool is_free(const DifferencesOf<float, Kind>& d) const {
    constexpr int kIterations = 2;
    const Tolerance<float> tolerance{scaled_thickness<float>(thickness, d.scale), float_above(delta * d.scale)};
    return !advance(d, tolerance, 1.0f, kIterations).hit;
  }
};

template <class Work, class Real, class Kind>
struct AdvanceCcd {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  double thickness, delta;
  Kind kind;
  Span<const uint64_t> candidates;
  ContactSink<Real> contacts;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (contacts.hurry.is_over()) return;
    DifferencesOf<Work, Kind> d;
    if (!load_differences<Kind, Work>(points_of(kind.stencil(candidates[i]), start, end), d))
      return contacts.report(candidates[i], {0, Real(0), Real(0), Real(0), uint8_t{kFlagCertified | kFlagInitial}});
    const Tolerance<Work> tolerance{scaled_thickness<Work>(thickness, d.scale),
                                    delta > 0 ? static_cast<Work>(delta * d.scale) : default_delta(Work(0)) * d.extent};
    const Advance<Work> found = advance(d, tolerance, static_cast<Work>(contacts.hurry.last()));
    if (!found.hit) return;
    contacts.report(candidates[i], contact_at<Real>(d, found.t, flags_of(d, found, tolerance.thickness)));
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
};

}  // namespace collided
