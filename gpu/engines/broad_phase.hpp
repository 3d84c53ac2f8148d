#pragma once
// The interface between a step and a broad phase. Each engine is a class that models BroadPhase, has a folder of its
// own, and is a row of the table in engines/engines.hpp.

#include <concepts>

#include "gpu/state/context.hpp"
#include "gpu/state/plan.hpp"

namespace collided {

/// A sink that takes no pairs, for the concept.
struct AnySink {
  COLLIDED_HD void operator()(uint32_t, uint32_t) const {}
};

/// Finds all pairs of triangles whose boxes overlap and which the scene's filter lets through, each once. All engines
/// find the same pairs. Everything is enqueued for the backend in this order: clear, measure, build, search once for
/// each kind of contacts.
template <class Phase>
concept BroadPhase = requires(Phase& phase, const Phase& fixed, StepPlan& plan, const StepPlan& step,
                              const StepState& found, FrameCounts& counts, uint64_t* next_item) {
  // Returns true for the values of Engine that the class serves; kEngine stands for it where engines compete.
  { Phase::serves(Engine::kAuto) } -> std::same_as<bool>;
  { Phase::kEngine } -> std::convertible_to<Engine>;
  // Prepares for a scene with another number of triangles.
  phase.resize();
  // Adds its own part to the plan of a step that it serves; then the steps of such a plan begin.
  fixed.plan(plan);
  phase.begin(step);
  // Allocates what a step needs: lists as long as is known by now. Throws ResourceExhausted.
  phase.reserve();
  // Empties its counters.
  phase.clear();
  // Measures the scene, and prepares the narrow phase with its bounds (StepContext::prepare_narrow).
  phase.measure();
  phase.build();
  // Hands all pairs to the sink. `next_item` is a zeroed counter on the backend. The last: it is the step's first
  // search.
  phase.search("", AnySink{}, next_item, true);
  // After a step: makes room for what it found. Returns true if it has to run again.
  { phase.grow(found) } -> std::same_as<bool>;
  // Of a step that had room for everything: returns true if it has to run again in another way, which is faster.
  { phase.must_refine(found) } -> std::same_as<bool>;
  // Learns from the last run of a step, and completes its counts.
  phase.finish(found, counts);
  { fixed.holds_memory() } -> std::same_as<bool>;
  phase.release();
};

/// Does nothing where most engines have nothing to do.
struct BroadPhaseDefaults {
  void resize() {}
  void plan(StepPlan&) const {}
  void clear() {}
  void build() {}
  bool grow(const StepState&) { return false; }
  bool must_refine(const StepState&) { return false; }
};

}  // namespace collided
