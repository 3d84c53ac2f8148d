#pragma once
// What the octree's next step is like, from what the last ones found.

#include "gpu/engines/octree/cell_grid.hpp"
#include "gpu/engines/octree/octree_plan.hpp"
#include "gpu/engines/octree/refinement.hpp"
#include "gpu/state/usage_predictor.hpp"

namespace collided {

class OctreePlanner {
 public:
  explicit OctreePlanner(uint64_t triangles) { resize(triangles); }

  /// The scene has so many triangles from the next step on.
  void resize(uint64_t triangles) {
    const int deepest = deepest_base(triangles);
    if (deepest != levels_.deepest) levels_ = widened_levels_ = {.deepest = deepest};
  }

  /// `is_ready`: for triangles that cover many cells, whether or not any are expected. `widened`: as in levels().
  OctreePlan plan(Engine engine, bool is_ready, bool widened) const {
    const ActiveLevels& levels = this->levels(widened);
    OctreePlan plan{engine, {cut_rule_of(engine), kRegistrationCost}};
    plan.levels = levels.deepest + 1, plan.base = levels.deepest;
    if (has_cells_of_triangles(engine))
      plan.levels = has_one_level(engine) ? 1 : kLevelsOfCrowdedCell + 1;
    else if (levels.base >= 0)
      plan.levels = levels.base - levels.top + 1, plan.base = levels.base;
    plan.has_large = large_.is_expected() || is_ready;
    if (engine != Engine::kOctree) return plan;
    plan.rounds = refinement_.rounds();
    plan.max_crowded_tests = refinement_.limit();
    return plan;
  }
  /// `widened`: of steps whose boxes are widened to list neighbours. They have levels of their own: those that suit
  /// large boxes are too coarse for the steps after, which would keep them, as next_levels() changes levels
  /// reluctantly.
  const ActiveLevels& levels(bool widened) const {
    return widened && widened_levels_.base >= 0 ? widened_levels_ : levels_;
  }

  // Of a step that ran: whether it has to run again, by another plan.
  bool missed_large(const StepState& step, const OctreePlan& plan) {
    return large_.observe(step.large > 0) && !plan.has_large;
  }
  /// Only where the step had room for all that it found: else it tells nothing of what refinement is good for.
  bool needs_refinement(const StepState& step, const OctreePlan& plan) {
    return plan.engine == Engine::kOctree && refinement_.observe(step);
  }

  /// Looks at the last run of a step of an engine that chooses its levels.
  void learn_levels(const StepState& step, bool widened) {
    const auto& grid = step.grid.grid;
    (widened ? widened_levels_ : levels_) =
        next_levels({grid.top, grid.base, levels_.deepest}, step.leaves.level_registrations);
  }

 private:
  /// In pair tests. From 0 to 4 it makes no difference to the time beyond 2 % in all (tests/bench/results, registration
  /// weight); with 0 no other cut of the same grid makes fewer tests.
  static constexpr float kRegistrationCost = 0;

  ActiveLevels levels_{.deepest = -1}, widened_levels_{.deepest = -1};
  Refinement refinement_;
  UsagePredictor large_;  ///< triangles that cover many cells
};

}  // namespace collided
