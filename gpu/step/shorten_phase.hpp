#pragma once
// Shortens ways until all pairs of features keep their floors (narrow/shortening.hpp). A step of the pipeline finds the
// pairs that some fractions of the ways could bring below their floors, and judges each of them at the frame's own
// positions. Rounds follow. A round shortens what failed pairs propose, then judges the pairs again whose vertices this
// has moved. The backend goes from round to round by itself, for as long as no round needs the host.

#include "gpu/narrow/hulls_apart.hpp"
#include "gpu/state/context.hpp"
#include "gpu/step/blocking_pairs.hpp"

#ifndef __CUDACC__
#include "gpu/narrow/cpu/screen_hulls.hpp"
#endif

namespace collided {

template <Executor Exec, class Real>
class ShortenPhase {
 public:
  explicit ShortenPhase(const StepContext<Exec, Real>& context)
      : exec_(context.exec), counts_(context.counts), scene_(context.scene) {}

  /// The next steps have these needs.
  void begin(const LevelNeeds& needs) {
    rules_ = needs.ways;
    kinds_ = needs.kinds;
    halves_ = scene_.halves(needs.settings);
    contacts_within_ = needs.tells_contacts ? needs.settings.reach() + needs.settings.delta : 0;
  }
  /// Makes room for the pairs that there is a list for.
  void reserve() {
    scene_.ways.allocate(counts_.vertices);
    for_each_kind_of_pairs([&](int k, const auto&) {
      BlockingPairs<Exec>& blocking = scene_.blocking[k];
      begin_list(blocking.pairs, first_length(scene_.topology.triangle_count()), 0);
      blocking.allocate(blocking.pairs.capacity());
    });
  }

  // The step's own part, to where the frame wants to go.
  void measure_ways() {
    exec_.reduce_into("measure_ways", counts_.vertices, MeasureWay<Real>{scene_.start.data(), scene_.end.data()},
                      WaysMeasure{empty_box(), 0}, JoinMeasures{}, &state()->ways);
  }
  /// Measures all ways, and lets all vertices go all of theirs.
  void begin_ways() {
    FractionBuffers<Exec>& ways = scene_.ways;
    exec_.stage("advance", [&] {
      measure_ways();
      exec_.for_each(
          "begin_ways", counts_.vertices,
          BeginWays{ways.clearances.data(), ways.shares.data(), ways.fractions.data(), ways.changed_in.data()});
    });
  }
  /// Lists the candidates that some fractions of the ways could bring below their floors.
  template <class Kind>
  void screen(const Kind& kind) {
    constexpr int k = kIndexOf<Kind>;
    const Buffer<uint64_t, Exec>& candidates = scene_.candidates[k].kept;
    exec_.stage("advance", [&] {
      exec_.for_each("screen_hulls", Counted{&state()->kept[k], candidates.capacity()},
                     ScreenHulls<Real, Kind>{scene_.start.data(),
                                             scene_.end.data(),
                                             kind,
                                             rules_.floors.reach() + 2 * rules_.off,
                                             contacts_within_,
                                             scene_.deviations(true),
                                             candidates.all(),
                                             {scene_.blocking[k].pairs.all(), &state()->blocking[k]},
                                             halves_});
    });
  }
  /// Measures the distances that these start at, and judges them where all vertices go all of their ways.
  void judge_ways() {
    exec_.stage("advance", [&] {
      side_by_side([&]<class Kind>(int k, const Kind& kind) {
        exec_.for_each("measure_starts", pairs(k), MeasureStarts<Real, Kind>{ways_of(kind)});
      });
      judge_all();
    });
  }
  /// Judges all pairs, before the first round.
  void judge_all() {
    exec_.fill_zero(&state()->round, sizeof(RoundCounts));
    judge(nullptr);
  }

  /// Puts the pairs that have failed into `limits`, as contacts in canonical order, before the first round. `failed`:
  /// how many there are of each kind, as the host knows. `ids`: of the scene's features.
  void list_limits(const uint64_t (&failed)[kFeatureKinds], const FeatureRanks& ranks, const IdCounts& ids) {
    LimitBuffers<Exec>& limits = scene_.limits;
    const uint64_t count = failed[0] + failed[1];
    const OrderPlan plan{count > kFewContacts, 0};
    limits.reserve(count, plan, ids);
    const LimitList list{limits.keys.all(), limits.data.all(), limits.normals.all()};
    side_by_side([&]<class Kind>(int k, const Kind& kind) {
      exec_.for_each("measure_limits", failed[k],
                     MeasureLimits<Real, Kind>{ways_of(kind), scene_.blocking[k].failed.all(), ranks.begin[k],
                                               k == 0 ? 0 : failed[0], list});
    });
    exec_.fill_zero(&state()->kinds, sizeof(KindBegins));
    exec_.fill_zero(&state()->crowded_ranks, sizeof(uint64_t));
    const WriteContact<double> write{list.data, list.normals, ranks, limits.columns.columns(kFieldsOfLimits)};
    put_in_order(exec_, limits.order,
                 Unordered<WriteContact<double>>{{nullptr, count}, list.keys, ranks, &state()->kinds, write}, plan, ids,
                 &state()->crowded_ranks);
  }

  // Rounds. Positions are those that the fractions lead to.
  /// 1 on the backend after a round: another one follows that needs nothing of the host.
  const uint64_t* goes_on() const { return &state()->round.goes_on; }
  /// Lets failed pairs propose.
  void propose() {
    side_by_side([&]<class Kind>(int k, const Kind& kind) {
      const Buffer<uint64_t, Exec>& failed = scene_.blocking[k].failed;
      const Counted count{&state()->round.failed[k], failed.capacity()};
      exec_.for_each_group("propose_shares", count,
                           ProposeShares<Real, Kind>{ways_of(kind), failed.all(), count, &state()->round.number,
                                                     scene_.ways.shares.data()});
    });
  }
  /// Lets what stands take in what is connected to it. Returns the vertices that it took in.
  uint64_t join_islands(const Vec3<Real>* target) {
    exec_.fill_zero(&state()->round.joined, sizeof(uint64_t));
    for_each_kind_of_pairs([&]<class Kind>(int k, const Kind& kind) {
      WaysOfPairs<Real, Kind> ways = ways_of(kind);
      ways.end = target;
      exec_.for_each("join_islands", pairs(k),
                     JoinIslands<Real, Kind>{ways, scene_.ways.shares.data(), &state()->round.joined});
    });
    return exec_.peek(state()).round.joined;
  }
  /// Shortens all groups by the shares that were proposed.
  void take_shares() {
    FractionBuffers<Exec>& ways = scene_.ways;
    exec_.for_each("take_shares", counts_.vertices,
                   TakeShares{ways.shares.data(), ways.fractions.data(), ways.changed_in.data(), &state()->round});
  }
  /// Judges again what the round has changed. The round is over.
  void judge_changed() {
    judge(&state()->round.number);
    exec_.for_each("end_round", 1, EndRound{&state()->round});
  }

  // These follow the last round.
  /// Adds up what became of the ways to the target.
  void add_up(const Vec3<Real>* target) {
    exec_.reduce_into("gone", counts_.vertices,
                      GoneOfWay<Real>{scene_.start.data(), target, group_of(), scene_.ways.fractions.data(),
                                      &state()->ways, counts_.vertices},
                      GoneOfWay<Real>::nothing(), AddGone{}, &state()->gone);
  }
  /// Lists the vertices that go less than their whole ways to the target, or the first of each such group.
  void list_shortened(const Vec3<Real>* target, bool first_of_group) {
    FractionBuffers<Exec>& ways = scene_.ways;
    exec_.fill_zero(&state()->shortened, sizeof(uint64_t));
    exec_.for_each("mark_moving", counts_.vertices,
                   MarkMoving<Real>{&state()->round, scene_.start.data(), target, group_of(), ways.shares.data()});
    exec_.for_each("list_shortened", counts_.vertices,
                   ListShortened{group_of(),
                                 ways.fractions.data(),
                                 ways.shares.data(),
                                 first_of_group,
                                 {ways.shortened.all(), &state()->shortened}});
  }

 private:
  StepState* state() const { return scene_.state.data(); }
  const uint32_t* group_of() const { return scene_.topology.group_of.data(); }
  template <class Use>
  void for_each_kind_of_pairs(const Use& use) const {
    FeatureKinds::of(scene_.topology).for_each([&]<class Kind>(const Kind& kind) {
      if (value_of(kinds_, Kind::kKind)) use(kIndexOf<Kind>, kind);
    });
  }
  Counted pairs(int kind) const { return {&state()->blocking[kind], scene_.blocking[kind].pairs.capacity()}; }
  template <class Kind>
  WaysOfPairs<Real, Kind> ways_of(const Kind& kind) const {
    constexpr int k = kIndexOf<Kind>;
    return {scene_.start.data(),
            scene_.end.data(),
            kind,
            rules_.floors,
            scene_.blocking[k].pairs.all(),
            scene_.blocking[k].starts.all(),
            scene_.topology.joined(),
            group_of(),
            scene_.ways.clearances.data(),
            scene_.turns()};
  }
  void judge(const uint64_t* round) {
    side_by_side([&]<class Kind>(int k, const Kind& kind) {
      exec_.for_each("judge_pairs", pairs(k),
                     JudgePairs<Real, Kind>{ways_of(kind),
                                            scene_.ways.changed_in.data(),
                                            round,
                                            {scene_.blocking[k].failed.all(), &state()->round.failed[k]}});
    });
  }
  /// Both kinds at once, where the backend can.
  template <class Use>
  void side_by_side(const Use& use) const {
    const auto use_kind = [&](int wanted) {
      for_each_kind_of_pairs([&](int k, const auto& kind) {
        if (k == wanted) use(k, kind);
      });
    };
    exec_.concurrently([&] { use_kind(0); }, [&] { use_kind(1); });
  }

  Exec& exec_;
  const SceneCounts& counts_;
  SceneBuffers<Exec, Real>& scene_;
  WayRules rules_;
  double contacts_within_ = 0;  ///< what their positions say
  HalfThicknesses halves_;      ///< of contacts
  PerKind<bool> kinds_ = {};
};

}  // namespace collided
