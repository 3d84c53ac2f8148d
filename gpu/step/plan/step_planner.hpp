#pragma once
// Plans the next step from what the last ones found and how long they took: chooses its engine, and decides whether it
// makes lists of neighbours or reuses those that exist.

#include "gpu/state/plan.hpp"
#include "gpu/state/state.hpp"
#include "gpu/step/plan/engine_choices.hpp"
#include "gpu/step/plan/reuse_planner.hpp"

namespace collided {

class StepPlanner {
 public:
  /// Holds what plans depend on, apart from frames.
  struct Scene {
    uint64_t triangles;
    bool launches_cost;  ///< as in Executor
    bool has_branches;   ///< rules keep most pairs of meshes apart
    bool is_all_idle;    ///< no two meshes may touch
  };

  StepPlanner(const SceneSpec& spec, const Scene& scene) : choices_(engine_of(spec), rivals(scene)), reuse_(spec) {
    suit(scene);
  }

  /// Plans for a scene like this from the next step on.
  void resize(const Scene& scene) {
    choices_.choose_between(rivals(scene));
    suit(scene);
    forget_lists();
  }
  /// Drops the lists that were made.
  void forget_lists() { reuse_.forget(); }

  /// Begins a frame's step. `bounds` are those of the last one.
  void begin(const LevelNeeds& needs, const Box<float>& bounds) {
    lists_ = reuse_.begin(needs, bounds);
    facts_ = choices_.begin(needs, !uses_lists() && !is_idle());
  }
  StepPlan plan(const LevelNeeds& needs, bool boxes_static, const OrderPlan& order) const {
    StepPlan plan;
    plan.needs = needs, plan.engine = facts_.engine, plan.boxes_static = boxes_static;
    plan.order = order, plan.lists = lists_, plan.is_idle = is_idle();
    return plan;
  }
  const ListPlan& lists() const { return lists_; }
  bool uses_lists() const { return lists_.use != ListUse::kNone; }
  /// True if no two meshes may touch and the step makes no lists.
  bool is_idle() const { return is_all_idle_ && !uses_lists(); }
  TrackTimes track_times() const { return reuse_.times(lists_); }
  /// Returns the milliseconds that a thread may work on the step; 0: any number.
  double longest_step() const { return uses_lists() ? reuse_.longest_step(lists_) : choices_.longest_step(); }

  // The step did not end, because its lists took too long or had no room.
  void give_up_lists() { reuse_.give_up(), lists_ = {}; }
  void refuse_lists() { reuse_.refuse(), lists_ = {}; }
  /// Ends the lists: a vertex has left its track.
  void miss(const Displacement& found) { lists_ = reuse_.miss(found); }
  /// Replaces an engine that took too long or failed, if there is another one.
  void abandon_engine() { facts_ = choices_.abandon(); }
  /// Replaces an engine that had no room. Returns false if no other engine may need less.
  bool retreat() {
    const std::optional<EngineFacts> other = choices_.retreat();
    if (other) facts_ = *other;
    return other.has_value();
  }

  /// Ends the step. `work` is in milliseconds of the calling thread. `is_clean` is true if nothing was allocated for
  /// the step and later steps will run as it did.
  void end(const StepState& found, double work, bool is_clean, FrameResult& result) {
    choices_.end(result, found.totals.boxed(), found.bricks[0] > 0, is_clean && result.replays == 0);
    reuse_.end(lists_, found.displacement, found.neighbours[0] + found.neighbours[1], result.step_milliseconds, work,
               is_clean);
    result.reuse = reuse_.facts(lists_);
  }
  const EngineFacts& engine() const { return facts_; }
  /// Returns the number of tests in the lists.
  uint64_t listed_tests() const { return reuse_.length(); }
  bool is_idle(Engine engine) const { return choices_.is_idle(engine); }
  bool are_lists_idle() const { return reuse_.is_idle(); }

 private:
  static Rivals rivals(const Scene& scene) {
    return rivals_of(scene.triangles, scene.launches_cost, scene.has_branches);
  }
  void suit(const Scene& scene) {
    is_all_idle_ = scene.is_all_idle;
    reuse_.suit(!scene.is_all_idle && !is_launch_bound(scene.triangles, scene.launches_cost));
  }

  EngineChoices choices_;
  ReusePlanner reuse_;
  bool is_all_idle_ = false;
  ListPlan lists_;     ///< of the step in work
  EngineFacts facts_;  ///< likewise
};

}  // namespace collided
