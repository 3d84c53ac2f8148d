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

/// Keeps the candidates that no fixed direction at hand keeps apart over the whole step: a cheap filter in float, for
/// most that pass each other do so sideways. The direction is that of the closest points halfway.
template <class Real, class Kind>
struct ScreenCcd {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  double thickness;
  Kind kind;
  Span<const uint64_t> candidates;
  AppendList<uint64_t> survivors;

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint64_t key = candidates[i];
    DifferencesOf<float, Kind> d;
    if (load_differences<Kind, float>(points_of(kind.stencil(key), start, end), d) && is_apart(d)) return;
    survivors.push(key);
  }

 private:
  COLLIDED_HD bool is_apart(const DifferencesOf<float, Kind>& d) const {
    const Direction<float> closest = direction_of(gap_at(d, 0.5f).vector);
    return apart_all_along(d, closest, scaled_thickness<float>(thickness, d.scale));
  }
};

/// A candidate that float could not tell apart yet, and how far it came.
struct Suspect {
  uint64_t key;
  Progress progress;
};

COLLIDED_HD inline uint64_t key_of(uint64_t candidate) { return candidate; }
COLLIDED_HD inline uint64_t key_of(const Suspect& candidate) { return candidate.key; }
COLLIDED_HD inline Progress progress_of(uint64_t) { return {}; }
COLLIDED_HD inline Progress progress_of(const Suspect& candidate) { return candidate.progress; }

/// Advances in float for a few iterations: what is apart until then is as certain as it would be in double precision,
/// which has only the rest to do. Candidate: uint64_t or Suspect.
template <class Real, class Kind, class Candidate>
struct ApproachCcd {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  double thickness, delta;
  Kind kind;
  Span<const Candidate> candidates;
  AppendList<Suspect> suspects;
  int iterations;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Candidate candidate = candidates[i];
    const uint64_t key = key_of(candidate);
    DifferencesOf<float, Kind> d;
    if (!load_differences<Kind, float>(points_of(kind.stencil(key), start, end), d)) return suspects.push({key, {}});
    constexpr float kNear = 0x1p-16f;  // of the extent: where float comes near its limits
    const Tolerance<float> tolerance{scaled_thickness<float>(thickness, d.scale),
                                     larger(kNear * d.extent, float_above(delta * d.scale))};
    const Advance<float> found = advance(d, tolerance, 1.0f, progress_of(candidate), iterations);
    if (found.hit) suspects.push({key, {found.t, found.left}});
  }
};

/// Candidate: uint64_t or Suspect.
template <class Work, class Real, class Kind, class Candidate>
struct AdvanceCcd {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  double thickness, delta;
  Kind kind;
  Span<const Candidate> candidates;
  ContactSink<Real> contacts;
  int iterations;
  AppendList<Suspect> late;  ///< those that need more iterations; empty: they are contacts, as far as that is known

  COLLIDED_HD void operator()(uint64_t i) const {
    if (contacts.hurry.is_over()) return;
    DifferencesOf<Work, Kind> d;
    const Candidate candidate = candidates[i];
    const uint64_t key = key_of(candidate);
    if (!load_differences<Kind, Work>(points_of(kind.stencil(key), start, end), d))
      return contacts.report(key, {0, Real(0), Real(0), Real(0), uint8_t{kFlagCertified | kFlagInitial}});
    const Tolerance<Work> tolerance{scaled_thickness<Work>(thickness, d.scale),
                                    delta > 0 ? static_cast<Work>(delta * d.scale) : default_delta(Work(0)) * d.extent};
    const Advance<Work> found =
        advance(d, tolerance, static_cast<Work>(contacts.hurry.last()), progress_of(candidate), iterations);
    if (!found.hit) return;
    if (found.capped && !late.items.empty())
      return late.push({key, {float_below(static_cast<double>(found.t)), static_cast<float>(found.left)}});
    contacts.report(key, contact_at<Real>(d, found.t, flags_of(d, found, tolerance.thickness)));
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
