#pragma once
// Which engine finds the pairs of a frame. All find the same pairs, so that a scene that leaves the choice open may let
// measured times decide: the octree and the hierarchy take turns for a few frames, and the faster one stays until the
// next comparison. Times come from outside, in milliseconds of any clock.
//
// Before the first comparison counters decide: a scene starts with the octree, and the hierarchy takes over where a
// frame of the octree, after whatever refinement did for it, looks clearly wrong: more registrations than the dense
// levels alone may make, more pair tests than 512 for each triangle and 32 for each pair found explain, or bricks below
// the dense levels. Later that only ends a wait, for measurements know better.

#include <algorithm>
#include <array>
#include <optional>

#include "gpu/octree/bottom_up.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Engines on the octree's stages whose cells are as large as the triangles, not fractions of the scene.
inline bool has_cells_of_triangles(Engine engine) {
  return engine == Engine::kUniformGrid || engine == Engine::kTwoLevelGrid || engine == Engine::kVss;
}
/// Those of them that have one level of cells.
inline bool has_one_level(Engine engine) { return has_cells_of_triangles(engine) && engine != Engine::kTwoLevelGrid; }

inline CutRule cut_rule_of(Engine engine) {
  if (engine == Engine::kTopDown) return CutRule::kTopDown;
  if (engine == Engine::kBottomUp) return CutRule::kBottomUp;
  return has_one_level(engine) ? CutRule::kGrid : CutRule::kTwoStage;
}

/// Whether a frame of the octree looks as if the hierarchy did better. `refined`: with bricks.
inline bool looks_wrong(const FrameCounts& counts, uint64_t triangles, bool refined) {
  return refined || counts.registrations > 24 * triangles || counts.tests > 512 * triangles + 32 * counts.pairs;
}

/// The last three of many numbers.
class LastTimes {
 public:
  void push(double milliseconds) {
    times_[next_] = milliseconds;
    next_ = (next_ + 1) % kKept;
    count_ = std::min(count_ + 1, kKept);
  }
  void clear() { count_ = next_ = 0; }
  bool is_full() const { return count_ == kKept; }
  /// The last where there are not as many yet; 0 without any.
  double median() const {
    if (count_ == 0) return 0;
    if (!is_full()) return times_[count_ - 1];
    const auto [a, b, c] = times_;
    return std::max(std::min(a, b), std::min(std::max(a, b), c));
  }

 private:
  static constexpr int kKept = 3;
  std::array<double, kKept> times_ = {};
  int count_ = 0, next_ = 0;
};

class EngineChoice {
 public:
  /// What a frame that an engine has done in full took.
  struct Measured {
    double search = 0;      ///< from positions to candidates, of the step's last run
    double total = 0;       ///< of the whole frame, whatever delayed it
    bool is_clean = true;   ///< the step ran once, and nothing was allocated for it
    bool is_wrong = false;  ///< looks_wrong(), of the octree
  };

  explicit EngineChoice(Engine wanted = Engine::kAuto)
      : is_open_(wanted == Engine::kAuto),
        why_{is_open_ ? Engine::kOctree : wanted, is_open_ ? EngineReason::kFirst : EngineReason::kAsked} {}

  /// Of the next frame.
  EngineFacts next() const { return trial_ ? trial_facts() : why_; }
  /// Of a frame that is not observed.
  const EngineFacts& settled() const { return why_; }

  /// Looks at a frame of next().
  void observe(const Measured& frame) {
    if (!is_open_) return;
    if (trial_) return observe_trial(frame);
    if (is_settling_) owe(frame.total);  // what begins anew after a comparison is its cost, too
    is_settling_ = false;
    if (frame.is_wrong && !tolerates_wrong_ && why_.engine == Engine::kOctree) return leave_octree();
    owed_ = std::max(0.0, owed_ - kShare * frame.total);
    wait_ = std::max(0, wait_ - 1);
    if (!frame.is_clean) return;
    search_.push(frame.search);
    total_.push(frame.total);
    if (has_changed()) wait_ = std::min(wait_, pause_ = kFirstPause);
    if (wait_ == 0 && owed_ == 0 && search_.is_full()) trial_.emplace(Trial{other_than(why_.engine)});
  }

  /// The frame of next() did not end.
  void abandon() {
    if (trial_) lose();
  }
  /// It had no room: back to the engine before, which needs less. Whether there is one.
  bool retreat() {
    const bool is_new = why_.reason == EngineReason::kCounters && !search_.is_full();
    if (!trial_ && !is_new) return false;
    if (is_new) why_ = {Engine::kOctree, EngineReason::kFirst}, tolerates_wrong_ = true;
    lose();
    return true;
  }

 private:
  static constexpr double kShare = 0.02;  ///< of all time may go to comparisons
  static constexpr double kGain = 0.97;   ///< what another engine has to take of the time to be chosen
  static constexpr double kHopeless = 2;  ///< times the time: one frame is enough to know
  static constexpr double kChange = 1.3;  ///< from here on a scene has become another one
  static constexpr int kFirstPause = 64;  ///< frames between comparisons; twice as many after each
  static constexpr int kLongestPause = 1 << 14;
  static constexpr int kLongestTrial = 12;  ///< frames, of which some are not clean

  struct Trial {
    Engine engine;
    int frames = 0, hopeless = 0;
    LastTimes search = {};
    bool is_wrong = false;
  };

  static Engine other_than(Engine engine) { return engine == Engine::kOctree ? Engine::kLbvh : Engine::kOctree; }
  EngineFacts trial_facts() const {
    EngineFacts facts = why_;
    facts.engine = trial_->engine, facts.reason = EngineReason::kTrial;
    return facts;
  }

  /// The first frame of a trial only makes room. A single frame may take long for reasons of its own.
  void observe_trial(const Measured& frame) {
    owe(frame.total);
    trial_->is_wrong |= frame.is_wrong;
    const bool is_first = trial_->frames++ == 0;
    const double hopeless = kHopeless * search_.median();
    trial_->hopeless = frame.search > hopeless ? trial_->hopeless + 1 : 0;
    if (trial_->hopeless > 1 || frame.search > 4 * hopeless) return decide(frame.search);
    if (!is_first && frame.is_clean) trial_->search.push(frame.search);
    if (trial_->search.is_full()) return decide(trial_->search.median());
    if (trial_->frames == kLongestTrial) lose();
  }

  void decide(double milliseconds) {
    const Trial trial = *trial_;
    const double before = search_.median();
    const bool is_better = milliseconds < kGain * before;
    end_trial();
    (trial.engine == Engine::kOctree ? why_.octree_milliseconds : why_.lbvh_milliseconds) = milliseconds;
    (trial.engine == Engine::kOctree ? why_.lbvh_milliseconds : why_.octree_milliseconds) = before;
    why_.reason = EngineReason::kFaster;
    if (!is_better) return;
    why_.engine = trial.engine;
    search_ = trial.search;
    if (why_.engine == Engine::kOctree) tolerates_wrong_ = trial.is_wrong;
  }
  /// Without knowing how long the other engine takes.
  void lose() {
    end_trial();
    wait_ = pause_ = kLongestPause;
  }
  void end_trial() {
    trial_.reset();
    is_settling_ = true;
    wait_ = pause_;
    pause_ = std::min(2 * pause_, kLongestPause);
  }

  void leave_octree() {
    why_.engine = Engine::kLbvh, why_.reason = EngineReason::kCounters;
    search_.clear();
    wait_ = 0;
  }

  void owe(double total) { owed_ += std::max(0.0, total - total_.median()); }
  /// The engine takes clearly more or less than when it was compared.
  bool has_changed() const {
    const double then = why_.engine == Engine::kOctree ? why_.octree_milliseconds : why_.lbvh_milliseconds;
    const double now = search_.median();
    return then > 0 && search_.is_full() && (now > kChange * then || now * kChange < then);
  }

  bool is_open_;
  EngineFacts why_;             ///< of the engine between trials
  std::optional<Trial> trial_;  ///< of the other one
  LastTimes search_, total_;    ///< of clean frames of the engine between trials
  double owed_ = 0;             ///< milliseconds that comparisons took, less the share of all time that they may take
  int wait_ = 0, pause_ = kFirstPause;
  bool tolerates_wrong_ = false;  ///< measured: the octree is faster although it looks wrong
  bool is_settling_ = false;      ///< the next frame is the first after a trial
};

}  // namespace collided
