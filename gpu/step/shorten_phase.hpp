#pragma once
// Shortens ways until all pairs of features keep their floors (narrow/shortening.hpp). A step of the pipeline finds the
// pairs that some fractions of the ways could bring below their floors, and judges each of them at the frame's own
// positions. Rounds follow. A round shortens what failed pairs propose, then judges the pairs again whose vertices this
// has moved. The host reads how many have failed, and nothing else; on a GPU only after several rounds.

#include <vector>

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
  /// Lets all vertices go all of their ways.
  void begin_ways() {
    FractionBuffers<Exec>& ways = scene_.ways;
    exec_.for_each(
        "begin_ways", counts_.vertices,
        BeginWays{ways.clearances.data(), ways.shares.data(), ways.fractions.data(), ways.changed_in.data()});
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
                                             {scene_.blocking[k].pairs.all(), &state()->blocking[k]}});
    });
  }
  /// Measures the distances that these start at, and judges them where all vertices go all of their ways.
  void judge_ways() {
    reserve();  // a step by parts has made room for pairs since
    exec_.stage("advance", [&] {
      for_each_kind_of_pairs([&]<class Kind>(int k, const Kind& kind) {
        exec_.for_each("measure_starts", pairs(k), MeasureStarts<Real, Kind>{ways_of(kind)});
      });
      judge_all();
    });
  }
  /// Judges all pairs.
  void judge_all() { judge(0); }

  // Rounds. Positions are those that the fractions lead to.
  /// Lets failed pairs propose.
  void propose(uint32_t round) {
    const Shortening how = shortening_of(round);
    side_by_side([&]<class Kind>(int k, const Kind& kind) {
      const Buffer<uint64_t, Exec>& failed = scene_.blocking[k].failed;
      exec_.for_each("propose_shares", Counted{&state()->round.failed[k], failed.capacity()},
                     ProposeShares<Real, Kind>{ways_of(kind), failed.all(), how, scene_.ways.shares.data()});
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
  void take_shares(uint32_t round) {
    FractionBuffers<Exec>& ways = scene_.ways;
    exec_.for_each("take_shares", counts_.vertices,
                   TakeShares{ways.shares.data(), ways.fractions.data(), ways.changed_in.data(), round + 1});
  }
  /// Judges again what the round has changed.
  void judge_changed(uint32_t round) { judge(round + 1); }

  /// Adds up what became of the ways to the target. Waits.
  WaysGone add_up(const Vec3<Real>* target, float longest) {
    const double most = 0x1p63 / static_cast<double>(counts_.vertices);  // no sum reaches 2^64
    const double units = longest > 0 ? std::exp2(std::floor(std::log2(most / longest))) : 1;
    exec_.reduce_into("gone", counts_.vertices,
                      GoneOfWay<Real>{scene_.start.data(), target, group_of(), scene_.ways.fractions.data(), units},
                      GoneOfWay<Real>::nothing(), AddGone{}, &state()->gone);
    return exec_.peek(state()).gone;
  }
  /// Returns the fraction of each group that moves towards the target; 1 of all others.
  std::vector<double> fractions(const Vec3<Real>* target) {
    FractionBuffers<Exec>& ways = scene_.ways;
    exec_.for_each(
        "tell_fractions", counts_.vertices,
        TellFractions<Real>{scene_.start.data(), target, group_of(), ways.fractions.data(), ways.shares.data()});
    std::vector<double> told(counts_.vertices);
    exec_.download(told.data(), ways.shares.data(), told.size() * sizeof(double));
    return told;
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
            scene_.ways.clearances.data()};
  }
  /// Judges the pairs that the round before this one has changed; all before the first.
  void judge(uint32_t round) {
    exec_.fill_zero(&state()->round, sizeof(RoundCounts));
    side_by_side([&]<class Kind>(int k, const Kind& kind) {
      exec_.for_each("judge_pairs", pairs(k),
                     JudgePairs<Real, Kind>{ways_of(kind), scene_.ways.changed_in.data(), round,
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
  PerKind<bool> kinds_ = {};
};

}  // namespace collided
