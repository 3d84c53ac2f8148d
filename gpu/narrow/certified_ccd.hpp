#pragma once
// CCD at the levels GUARDED (Work = float), CERTIFIED and EXACT (Work = double): no contact of the given positions is
// missed, and no time of impact is late.

#include "gpu/narrow/doubt.hpp"
#include "gpu/narrow/near_miss.hpp"
#include "gpu/narrow/separating.hpp"

namespace collided {

/// The contact's data at time t, as far as the features' differences tell.
template <class Real, class Work, int N>
COLLIDED_HD ContactData<Real> contact_at(const Differences<Work, N>& d, Work t, uint8_t flags) {
  const Gap<Work> gap = gap_at(d, t);
  const double distance = static_cast<double>(gap.length) / d.scale;
  return {static_cast<double>(t), static_cast<Real>(distance), static_cast<Real>(gap.points.w0),
          static_cast<Real>(gap.points.w1), flags};
}

/// The contact's data of features whose positions are the same.
template <class Real>
COLLIDED_HD ContactData<Real> coincident(const ContactDistance& distance, double doubt, uint8_t flags) {
  const bool is_sure = doubt == 0 || certain_distance(distance, doubt) > 0;
  return {0, Real(0), Real(0), Real(0), static_cast<uint8_t>(flags | (is_sure ? kFlagCertified : kFlagNear))};
}

/// A candidate that float could not tell apart, and how far it came: double precision resumes there.
struct ResumableQuery {
  uint64_t key;
  Progress progress;
};

COLLIDED_HD inline uint64_t key_of(uint64_t candidate) { return candidate; }
COLLIDED_HD inline uint64_t key_of(const ResumableQuery& candidate) { return candidate.key; }
COLLIDED_HD inline Progress progress_of(uint64_t) { return {}; }
COLLIDED_HD inline Progress progress_of(const ResumableQuery& candidate) { return candidate.progress; }

template <class Work, class Kind>
using AdvancementOf = Advancement<Work, DifferenceOf<Kind>::kCount>;

/// What the stages of the narrow phase look at. Candidate: uint64_t or ResumableQuery.
template <class Real, class Kind, class Candidate>
struct CcdQueries {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  double thickness;  ///< at t = 1; the filters take it for the whole step
  Doubt doubt;
  double delta;
  Kind kind;
  Span<const Candidate> candidates;
  HalfThicknesses halves = {};

  COLLIDED_HD uint64_t key(uint64_t i) const { return key_of(candidates[i]); }
  /// What the pair may be closer to each other than the straight paths of their positions, at most.
  COLLIDED_HD double doubt_of(uint64_t key) const { return doubt.of(kind, key); }
  /// Returns the contact distance of a pair at t = 1.
  COLLIDED_HD ContactDistance distance_of(uint64_t key) const { return distance_of(thickness, key); }
  /// The same in a scene of another thickness.
  COLLIDED_HD ContactDistance distance_of(double thickness, uint64_t key) const {
    return collided::distance_of(halves, thickness, kind, key);
  }
  /// Returns a distance that no contact's positions exceed.
  COLLIDED_HD double doubtful_distance_of(uint64_t key) const {
    return doubtful_distance(distance_of(key), doubt_of(key));
  }
  /// True if all pairs have the same.
  COLLIDED_HD bool has_one_distance() const { return !doubt.deviations.is_needed() && !halves.is_needed(); }
  COLLIDED_HD Progress progress(uint64_t i) const { return progress_of(candidates[i]); }
  /// As load_differences.
  template <class Work>
  COLLIDED_HD bool load(uint64_t i, DifferencesOf<Work, Kind>& out) const {
    return load_differences<Kind, Work>(points_of(kind.stencil(key(i)), start, end), out);
  }
};

/// One query on its way (for_each_resumable).
template <class Work, class Kind>
struct CcdState {
  AdvancementOf<Work, Kind> features;
  uint64_t key;

  COLLIDED_HD bool is_over() const { return features.is_over(); }
};

/// Keeps the candidates that no fixed direction at hand keeps apart over the whole step: a cheap filter in float, for
/// most that pass each other do so sideways. The direction is that of the closest points halfway.
template <class Real, class Kind>
struct ScreenCcd {
  CcdQueries<Real, Kind, uint64_t> queries;
  AppendList<uint64_t> survivors;

  COLLIDED_HD void operator()(uint64_t i) const {
    DifferencesOf<float, Kind> d;
    const uint64_t key = queries.key(i);
    if (queries.load(i, d)) {
      if (is_apart(d, scaled_thickness<float>(queries.doubtful_distance_of(key), d.scale))) return;
    }
    survivors.push(key);
  }

  /// `thickness`: scaled, rounded up.
  template <class Work>
  COLLIDED_HD static Mask<Work> is_apart(const DifferencesOf<Work, Kind>& d, Work thickness) {
    return apart_all_along(d, direction_of(gap_at(d, Work(0.5f)).vector), thickness);
  }
};

/// Advances in float for a few iterations: what is apart until then is as certain as it would be in double precision,
/// which has only the rest to do.
template <class Real, class Kind>
struct ApproachCcd {
  using State = CcdState<float, Kind>;
  static constexpr int kIterationsInFloat = 8;
  CcdQueries<Real, Kind, uint64_t> queries;
  AppendList<ResumableQuery> resumable;

  COLLIDED_HD void begin(uint64_t i, State& state) const {
    state.key = queries.key(i);
    DifferencesOf<float, Kind>& d = state.features.d;
    if (!queries.load(i, d)) {
      resumable.push(ResumableQuery{state.key, Progress{}});
      return;
    }
    const float thickness = scaled_thickness<float>(queries.doubtful_distance_of(state.key), d.scale);
    state.features.begin({{thickness, thickness}, delta_of(d)}, queries.progress(i), kIterationsInFloat);
  }
  COLLIDED_HD void step(State& state) const { state.features.iterate(1.0f); }
  COLLIDED_HD void finish(const State& state) const {
    if (state.features.is_hit())
      resumable.push(ResumableQuery{state.key, Progress{state.features.time(), state.features.pace()}});
  }
  /// Where float comes near its limits, or what the frame asks for.
  template <class Work>
  COLLIDED_HD Work delta_of(const DifferencesOf<Work, Kind>& d) const {
    constexpr float kNear = 0x1p-16f;  // of the extent
    return max(kNear * d.extent, float_above(queries.delta * d.scale));
  }
};

/// Pairs that the advancement reported as contacts and that may be near misses: their keys, and the times that they are
/// apart until. A later loop follows them. It needs many registers, and would slow all queries if they shared a kernel.
struct NearMissList {
  AppendList<uint64_t> keys;
  Span<uint64_t> time_bits;

  /// Both lists need a slot for every query.
  COLLIDED_HD void push(uint64_t key, double t) const {
    const uint64_t slot = claim_slot(*keys.count);
    if (slot >= keys.items.size() || slot >= time_bits.size()) return;
    keys.items[slot] = key;
    time_bits[slot] = detail::bit_copy<uint64_t>(t);
  }
};

/// Reports the contacts of advancements.
template <class Work, class Real, class Kind, class Candidate>
struct CcdReporter {
  CcdQueries<Real, Kind, Candidate> queries;
  double start_thickness;  ///< at t = 0, at most queries.thickness
  bool skips_separating;   ///< what comes no closer is no contact
  bool is_exact;           ///< contacts are to be decided where their paths are straight
  ContactSink<Real> contacts;

  COLLIDED_HD Tolerance<Work> tolerance_of(uint64_t key, const DifferencesOf<Work, Kind>& d, double doubt) const {
    const Work delta =
        queries.delta > 0 ? static_cast<Work>(queries.delta * d.scale) : default_delta(Work(0)) * d.extent;
    return {{scaled_thickness<Work>(doubtful_distance(start_distance_of(key), doubt), d.scale),
             scaled_thickness<Work>(doubtful_distance(queries.distance_of(key), doubt), d.scale)},
            delta};
  }
  COLLIDED_HD void report_coincident(uint64_t key, double doubt) const {
    contacts.report(key, coincident<Real>(start_distance_of(key), doubt, kFlagInitial | mark(doubt)));
  }
  /// A pair that is certain to be apart on [0, t) alone.
  COLLIDED_HD void report(uint64_t key, const DifferencesOf<Work, Kind>& d, const Tolerance<Work>& tolerance, Work t,
                          bool is_capped) const {
    const double doubt = queries.doubt_of(key);
    const bool separating = doubt == 0 && is_separating(key, d, tolerance, t);
    if (separating && skips_separating) return;
    const double certain = certain_distance(start_distance_of(key), doubt), by = known_by(d, t, doubt, certain);
    const uint8_t flags =
        flags_of(d, t, is_capped, certain, by < kNeverCertain) | (separating ? kFlagSeparating : 0) | mark(doubt);
    contacts.report(key, contact_at<Real>(d, t, flags), by);
  }

 private:
  COLLIDED_HD ContactDistance start_distance_of(uint64_t key) const {
    return queries.distance_of(start_thickness, key);
  }
  /// At kExact positions are what they are, so that there is no doubt but of arcs.
  COLLIDED_HD uint8_t mark(double doubt) const { return is_exact && doubt > 0 ? kFlagOnArc : uint8_t{0}; }
  /// As certain_by.
  COLLIDED_HD double known_by(const DifferencesOf<Work, Kind>& d, Work t, double doubt, double certain) const {
    if (doubt > 0 && certain == 0) return kNeverCertain;
    return certain_by(d, t, scaled_thickness<Work>(certain, d.scale));
  }
  COLLIDED_HD uint8_t flags_of(const DifferencesOf<Work, Kind>& d, Work t, bool is_capped, double certain,
                               bool is_sure) const {
    const Work thickness = scaled_thickness<Work>(certain, d.scale);
    uint8_t flags = is_sure ? kFlagCertified : kFlagNear;
    if (is_capped) flags |= kFlagCapped;
    // A sure contact may come after its lower bound 0.
    if (t == 0 && (!is_sure || touches_at(d, Work(0), thickness))) flags |= kFlagInitial;
    return flags;
  }
  /// Features within the thickness at t = 0; or, where the thickness grows, those that it catches up with. Float could
  /// tell hardly anything of it.
  COLLIDED_HD bool is_separating(uint64_t key, const DifferencesOf<Work, Kind>& scaled,
                                 const Tolerance<Work>& tolerance, Work t) const {
    const bool begins_within = t == 0;
    if (!begins_within && start_thickness == queries.thickness) return false;
    // What begins within is no farther apart than this.
    if (tolerance.thickness.end + tolerance.delta < static_cast<Work>(kTooClose) * scaled.extent) return false;
    DifferencesOf<double, Kind> d;
    if (!load_differences<Kind, double>(points_of(queries.kind.stencil(key), queries.start, queries.end), d))
      return false;
    return comes_no_closer(d, begins_within ? 0.0 : scaled_thickness<double>(start_distance_of(key).above(), d.scale));
  }
};

/// Advances to the end, and reports contacts; those in double that may be near misses are left to FollowNearMisses.
template <class Work, class Real, class Kind, class Candidate>
struct AdvanceCcd {
  using State = CcdState<Work, Kind>;
  CcdReporter<Work, Real, Kind, Candidate> reporter;
  NearMissList near_misses;

  COLLIDED_HD void begin(uint64_t i, State& state) const {
    if (reporter.contacts.early_exit.is_over()) return;
    state.key = reporter.queries.key(i);
    DifferencesOf<Work, Kind>& d = state.features.d;
    const double doubt = reporter.queries.doubt_of(state.key);
    if (!reporter.queries.load(i, d)) return reporter.report_coincident(state.key, doubt);
    state.features.begin(reporter.tolerance_of(state.key, d, doubt), reporter.queries.progress(i), kMaxIterations);
  }
  COLLIDED_HD void step(State& state) const {
    state.features.iterate(static_cast<Work>(reporter.contacts.early_exit.last()));
  }
  COLLIDED_HD void finish(const State& state) const {
    const AdvancementOf<Work, Kind>& features = state.features;
    if (!features.is_hit()) return;
    if constexpr (std::is_same_v<Work, double>)
      if (may_be_near_miss(features.d, features.tolerance(), features.time(), features.gap()))
        return near_misses.push(state.key, features.time());
    reporter.report(state.key, features.d, features.tolerance(), features.time(), features.is_capped());
  }
};

/// Follows the pairs of a list, and reports those that are contacts. Where they are few, a warp of a GPU shares the
/// directions of each pair, as the step waits for the one that takes longest; else each thread has a pair of its own.
template <class Real, class Kind>
struct FollowNearMisses {
  using Shared = Nothing;
  static constexpr uint32_t kGroupSize = 32, kGroupsOfProcessor = 8;
  CcdReporter<double, Real, Kind, uint64_t> reporter;  ///< its candidates are those of the list
  Span<const uint64_t> time_bits;
  Counted pairs;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Nothing&) const {
    share_few(i, group, pairs.size(), [&](uint64_t pair, const Group& team) { follow(pair, team); });
  }

 private:
  COLLIDED_HD void follow(uint64_t i, const Group& team) const {
    const EarlyExit& early_exit = reporter.contacts.early_exit;
    const double t = detail::bit_copy<double>(time_bits[i]);
    // All threads of a team have to go the same way.
    if (team.any(early_exit.is_over() || t > early_exit.last())) return;
    const uint64_t key = reporter.queries.key(i);
    DifferencesOf<double, Kind> d;
    const double doubt = reporter.queries.doubt_of(key);
    const bool differ = reporter.queries.load(i, d), reports = team.rank == 0;
    if (!differ) return reports ? reporter.report_coincident(key, doubt) : void();
    const Tolerance<double> tolerance = reporter.tolerance_of(key, d, doubt);
    const NearMiss found = follow_near_miss(d, tolerance, t, team);
    if (found.is_hit && reports) reporter.report(key, d, tolerance, found.t, found.is_capped);
  }
};

}  // namespace collided
