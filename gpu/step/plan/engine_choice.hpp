#pragma once
// Which engine finds the pairs of a frame. All find the same pairs, so that a scene that leaves the choice open may let
// measured times decide: two rivals take turns for a few frames, and the faster one stays until the next comparison.
// Times come from outside, in milliseconds of any clock. The rivals are the octree and the hierarchy, in small scenes
// all pairs and the octree.
//
// Before the first comparison counters decide where a scene starts with the octree: the hierarchy takes over where a
// frame of the octree, after whatever refinement did for it, looks clearly wrong: more registrations than the dense
// levels alone may make, more pair tests than 512 for each triangle and 32 for each pair found explain, or bricks below
// the dense levels. Later that only ends a wait, for measurements know better.

#include <optional>

#include "gpu/step/plan/trials.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Whether a frame of the octree looks as if the hierarchy did better. `refined`: with bricks.
inline bool looks_wrong(const FrameCounts& counts, uint64_t triangles, bool refined) {
  return refined || counts.registrations > 24 * triangles || counts.tests > 512 * triangles + 32 * counts.pairs;
}

/// Engines that a scene chooses between, from the first of them on. Where both are the same there is no choice.
struct Rivals {
  Engine first = Engine::kOctree, second = Engine::kLbvh;

  Engine other_than(Engine engine) const { return engine == first ? second : first; }
  bool operator==(const Rivals&) const = default;
};

inline double& milliseconds_of(EngineFacts& facts, Engine engine) {
  if (engine == Engine::kLbvh) return facts.lbvh_milliseconds;
  return engine == Engine::kAllPairs ? facts.all_pairs_milliseconds : facts.octree_milliseconds;
}

class EngineChoice {
 public:
  /// What a frame that an engine has done in full took.
  struct Measured {
    double search = 0;      ///< from positions to candidates, of the step's last run
    double total = 0;       ///< of the whole frame, whatever delayed it
    bool is_clean = true;   ///< the step ran once, and nothing was allocated for it
    bool is_wrong = false;  ///< looks_wrong(), of the octree
  };

  explicit EngineChoice(Engine wanted = Engine::kAuto, const Rivals& rivals = {})
      : is_open_(wanted == Engine::kAuto && rivals.first != rivals.second),
        rivals_(rivals),
        why_{wanted == Engine::kAuto ? rivals.first : wanted,
             wanted == Engine::kAuto ? EngineReason::kFirst : EngineReason::kAsked} {}

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
    budget_.earn(frame.total);
    budget_.count_frame();
    if (!frame.is_clean) return;
    search_.push(frame.search);
    total_.push(frame.total);
    if (has_changed()) budget_.hurry();
    if (budget_.is_due() && search_.is_full()) trial_.emplace(Trial{rivals_.other_than(why_.engine)});
  }

  /// Returns the milliseconds after which a frame of a trial is given up, because nothing yet shows how slow the engine
  /// is; 0 outside trials.
  double longest_trial() const {
    constexpr double kLeast = 50;  // threads may wait for processors
    return trial_ ? std::max(kLeast, 2 * kHopeless * total_.median()) : 0;
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
  static constexpr double kShare = 0.0075;  ///< of all time may go to comparisons
  static constexpr double kHopeless = 2;    ///< times the time: one frame is enough to know
  static constexpr double kSlower = 1.15;   ///< times the time: two frames are
  static constexpr int kLongestTrial = 12;  ///< frames, of which some are not clean

  struct Trial {
    Engine engine;
    int frames = 0, hopeless = 0, slower = 0;
    LastTimes search = {};
    bool is_wrong = false;
  };

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
    if (!is_first && frame.is_clean) {
      trial_->search.push(frame.search);
      trial_->slower = frame.search > kSlower * search_.median() ? trial_->slower + 1 : 0;
      if (trial_->slower > 1) return decide(frame.search);
    }
    if (trial_->search.is_full()) return decide(trial_->search.median());
    if (trial_->frames == kLongestTrial) lose();
  }

  void decide(double milliseconds) {
    const Trial trial = *trial_;
    const double before = search_.median();
    const bool is_better = milliseconds < TrialBudget::kGain * before;
    end_trial(is_better ? 1 : milliseconds / before);  // what has won once is looked at again soon
    milliseconds_of(why_, trial.engine) = milliseconds;
    milliseconds_of(why_, why_.engine) = before;
    why_.reason = EngineReason::kFaster;
    if (!is_better) return;
    budget_.forgive();
    why_.engine = trial.engine;
    search_ = trial.search;
    if (why_.engine == Engine::kOctree) tolerates_wrong_ = trial.is_wrong;
  }
  /// Without knowing how long the other engine takes.
  void lose() {
    end_trial();
    budget_.pause_longest();
  }
  void end_trial(double ratio = 1) {
    trial_.reset();
    is_settling_ = true;
    budget_.pause(ratio);
  }

  void leave_octree() {
    why_.engine = rivals_.other_than(Engine::kOctree), why_.reason = EngineReason::kCounters;
    search_.clear();
    budget_.end_pause();
  }

  void owe(double total) { budget_.owe(total - total_.median()); }
  /// The engine takes clearly more or less than when it was compared.
  bool has_changed() {
    const double then = milliseconds_of(why_, why_.engine), now = search_.median();
    constexpr double kChange = TrialBudget::kChange;
    return then > 0 && search_.is_full() && (now > kChange * then || now * kChange < then);
  }

  bool is_open_;
  Rivals rivals_;
  EngineFacts why_;             ///< of the engine between trials
  std::optional<Trial> trial_;  ///< of the other one
  LastTimes search_, total_;    ///< of clean frames of the engine between trials
  TrialBudget budget_{0, kShare};
  bool tolerates_wrong_ = false;  ///< measured: the octree is faster although it looks wrong
  bool is_settling_ = false;      ///< the next frame is the first after a trial
};

}  // namespace collided
