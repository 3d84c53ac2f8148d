#pragma once
// The choices of a scene between engines, and what they go by: how long the search for candidates took.

#include <algorithm>
#include <array>
#include <chrono>
#include <string_view>
#include <vector>

#include "gpu/state/level_needs.hpp"
#include "gpu/step/plan/engine_choice.hpp"

namespace collided {

/// Of the last step among the stages, from positions to candidates.
inline double search_milliseconds(const std::vector<StageTime>& stages) {
  static constexpr std::string_view kFirst = "boxes";
  static constexpr std::string_view kOthers[] = {"levels",       "count", "refine",    "bottom_up", "top_down",
                                                 "registration", "sort",  "hierarchy", "pairs",     "pairs_tt"};
  double milliseconds = 0;
  for (auto stage = stages.rbegin(); stage != stages.rend(); ++stage) {
    if (stage->stage == kFirst) return milliseconds + stage->milliseconds;
    if (std::ranges::find(kOthers, stage->stage) != std::end(kOthers)) milliseconds += stage->milliseconds;
  }
  return milliseconds;
}

/// Each world has a hierarchy of its own; other engines would search all together.
inline Engine engine_of(const SceneSpec& spec) {
  return spec.worlds > 0 && spec.engine == Engine::kAuto ? Engine::kLbvh : spec.engine;
}

/// Scenes so small that on a GPU (`launches_cost`) launches take longer than any search. Neither engines nor lists of
/// neighbours are tried there: a trial allocates, and makes the step's graph anew, which holds up all other scenes.
inline bool is_launch_bound(uint64_t triangles, bool launches_cost) {
  constexpr uint64_t kVeryFew = 2048;
  return launches_cost && triangles <= kVeryFew;
}

/// What a scene of so many triangles chooses between, from the same first engine on all backends, so that counts of
/// first frames are the same. Up to here testing all pairs takes a GPU no longer than making a tree; where it does the
/// other engine wins the first comparison. `has_branches`: rules keep pairs apart, which the hierarchy passes over
/// where the octree refines crowded cells for them, at 11 s for the first frame of 700 probes in one place.
inline Rivals rivals_of(uint64_t triangles, bool launches_cost, bool has_branches) {
  constexpr uint64_t kFew = 4096;
  if (is_launch_bound(triangles, launches_cost)) return {Engine::kAllPairs, Engine::kAllPairs};
  const Rivals trees = has_branches ? Rivals{Engine::kLbvh, Engine::kOctree} : Rivals{};
  return triangles <= kFew ? Rivals{Engine::kAllPairs, trees.first} : trees;
}

/// Frames whose searches are alike share a choice. A step that may end early, or that no frame asked for, tells nothing
/// of the engines: it goes by what the others chose.
class EngineChoices {
 public:
  explicit EngineChoices(Engine wanted, const Rivals& rivals = {}) : wanted_(wanted) { begin_anew(rivals); }

  /// From the next step on.
  void choose_between(const Rivals& rivals) {
    if (rivals != rivals_) begin_anew(rivals);
  }

  /// A step begins. `searches`: and it does nothing but search; else it goes by what other steps chose.
  EngineFacts begin(const LevelNeeds& needs, bool searches = true) {
    const size_t which = 2 * needs.is_ccd() + needs.filters_searches();
    is_used_[which] = true;
    is_observed_ = searches && !needs.is_any_hit() && !needs.finds_rest_pairs;
    choice_ = &choices_[which];
    begin_ = Clock::now();
    return is_observed_ ? choice_->next() : choice_->settled();
  }
  /// It has ended. `triangles`: that had boxes; `refined`: with bricks; `is_clean`: it ran once, as later ones will.
  void end(const FrameResult& result, uint64_t triangles, bool refined, bool is_clean) {
    if (!is_observed_) return;
    const std::chrono::duration<double, std::milli> total = Clock::now() - begin_;
    const bool is_octree = result.broad_phase.engine == Engine::kOctree;
    choice_->observe({search_milliseconds(result.stages), total.count(), is_clean,
                      is_octree && looks_wrong(result.counts, triangles, refined)});
  }
  /// Returns the milliseconds that a thread may work on the step; 0: any number.
  double longest_step() const { return is_observed_ ? choice_->longest_trial() : 0; }
  /// Ends a trial whose step took longer or failed. Returns the engine that the step uses from here on.
  EngineFacts abandon() {
    if (is_observed_) choice_->abandon();
    return choice_->settled();
  }
  /// There was no room for it: the engine that it is to be done with instead, if there is another.
  std::optional<EngineFacts> retreat() {
    if (!is_observed_ || !choice_->retreat()) return {};
    return choice_->next();
  }

  /// None of the frames so far would use the engine next.
  bool is_idle(Engine engine) const {
    if (wanted_ != Engine::kAuto) return false;
    for (size_t i = 0; i < choices_.size(); ++i)
      if (is_used_[i] && (choices_[i].next().engine == engine || choices_[i].settled().engine == engine)) return false;
    return true;
  }

 private:
  using Clock = std::chrono::steady_clock;

  void begin_anew(const Rivals& rivals) {
    rivals_ = rivals;
    choices_.fill(EngineChoice(wanted_, rivals));
  }

  Engine wanted_;
  Rivals rivals_;
  std::array<EngineChoice, 4> choices_;
  std::array<bool, 4> is_used_ = {};
  EngineChoice* choice_ = nullptr;  ///< of the step in work
  bool is_observed_ = false;
  Clock::time_point begin_;
};

}  // namespace collided
