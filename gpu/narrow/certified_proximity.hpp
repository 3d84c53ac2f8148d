#pragma once
// DCD at the levels GUARDED (Work = float), CERTIFIED and EXACT (Work = double): no features of the frame within the
// thickness are missed. A step that stands still: a direction either keeps the features apart or does not.

#include "gpu/narrow/certified_ccd.hpp"

namespace collided {

/// Whether the features are certain to be farther apart than the thickness; false says nothing.
template <class Work, int N>
COLLIDED_HD bool are_apart(const Differences<Work, N>& d, Work thickness) {
  return View<Work, N>::at(d, Work(0), {thickness, thickness}).directed.is_apart();
}

/// Keeps the candidates that float cannot tell apart.
template <class Real>
struct NearInFloat {
  double thickness;
  bool differs_by_pair = false;  ///< each pair has a distance of its own, which its boxes are inflated by, together

  /// Returns the filter for a pair whose boxes are inflated by these.
  COLLIDED_HD NearInFloat between(Real inflation, Real other) const {
    if (!differs_by_pair) return *this;
    return {Deviations::widened(static_cast<double>(inflation), static_cast<double>(other))};
  }

  template <class Kind>
  COLLIDED_HD bool operator()(const Kind&, const FeaturePoints<Real>& points) const {
    DifferencesOf<float, Kind> d;
    return !load_differences<Kind, float>(points, d) || !are_apart(d, scaled_thickness<float>(thickness, d.scale));
  }
};

template <class Work, class Real, class Kind>
struct CertifyProximity {
  const Vec3<Real>* positions;
  double thickness;
  double doubt;  ///< of every pair: its positions were encoded
  Kind kind;
  Span<const uint64_t> candidates;
  ContactSink<Real> contacts;
  AppendList<uint64_t> near_misses;  ///< in double: pairs that are left to SeparateNearMisses
  HalfThicknesses halves = {};

  COLLIDED_HD ContactDistance distance_of(uint64_t key) const {
    return collided::distance_of(halves, thickness, kind, key);
  }
  COLLIDED_HD void operator()(uint64_t i) const {
    if (contacts.early_exit.is_over()) return;
    const ContactDistance distance = distance_of(candidates[i]);
    DifferencesOf<Work, Kind> d;
    if (!load_differences<Kind, Work>(points_of(kind.stencil(candidates[i]), positions, positions), d))
      return contacts.report(candidates[i], coincident<Real>(distance, doubt, 0));
    const Work widened = scaled_thickness<Work>(doubtful_distance(distance, doubt), d.scale);
    if (are_apart(d, widened)) return;
    const Work certain = scaled_thickness<Work>(certain_distance(distance, doubt), d.scale);
    const uint8_t flags = touches_at(d, Work(0), certain) ? kFlagCertified : kFlagNear;
    if constexpr (std::is_same_v<Work, double>)
      if (flags == kFlagNear && may_be_near_miss(d, {{widened, widened}, 0}, 0.0, gap_at(d, 0.0).length)) {
        near_misses.push(candidates[i]);
        return;
      }
    contacts.report(candidates[i], contact_at<Real>(d, Work(0), flags));
  }
};

/// Reports the pairs of a list that no precise direction keeps apart by more than the thickness.
template <class Real, class Kind>
struct SeparateNearMisses {
  CertifyProximity<double, Real, Kind> pairs;  ///< its candidates are those of the list

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint64_t key = pairs.candidates[i];
    DifferencesOf<double, Kind> d;
    load_differences<Kind, double>(points_of(pairs.kind.stencil(key), pairs.positions, pairs.positions), d);
    const double reach = doubtful_distance(pairs.distance_of(key), pairs.doubt),
                 widened = scaled_thickness<double>(reach, d.scale);
    if (!are_precisely_apart(d, {widened, widened}, 0.0))
      pairs.contacts.report(key, contact_at<Real>(d, 0.0, kFlagNear));
  }
};

}  // namespace collided
