#pragma once
// The engines of a scene: the table of broad phases, and the one place that chooses between them by Engine.

#include <tuple>

#include "gpu/engines/all_pairs/all_pairs_phase.hpp"
#include "gpu/engines/broad_phase.hpp"
#include "gpu/engines/lbvh/lbvh_phase.hpp"
#include "gpu/engines/octree/octree_phase.hpp"

namespace collided {

template <Executor Exec, class Real>
class Engines {
  /// A row for each engine.
  using Table = std::tuple<OctreePhase<Exec, Real>, LbvhPhase<Exec, Real>, AllPairsPhase<Exec, Real>>;

 public:
  explicit Engines(const StepContext<Exec, Real>& context) : Engines(context, std::make_index_sequence<kCount>{}) {}

  void resize() {
    for_each([](auto& phase) { phase.resize(); });
  }
  /// Completes the plan of a step by what its engine decides.
  void plan(StepPlan& step) {
    step.octree = {};
    with(step.engine, [&](auto& phase) { phase.plan(step); });
  }
  /// From here on the calls below are for the engine of this plan.
  void begin(const StepPlan& step) {
    engine_ = step.engine;
    with(engine_, [&](auto& phase) { phase.begin(step); });
  }

  // As in BroadPhase.
  void reserve() {
    with(engine_, [](auto& phase) { phase.reserve(); });
  }
  void clear() {
    with(engine_, [](auto& phase) { phase.clear(); });
  }
  void measure() {
    with(engine_, [](auto& phase) { phase.measure(); });
  }
  void build() {
    with(engine_, [](auto& phase) { phase.build(); });
  }
  template <class Sink>
  void search(const char* name, const Sink& sink, uint64_t* next_item, bool is_first) {
    with(engine_, [&](auto& phase) { phase.search(name, sink, next_item, is_first); });
  }
  bool grow(const StepState& found) {
    bool grew = false;
    with(engine_, [&](auto& phase) { grew = phase.grow(found); });
    return grew;
  }
  bool must_refine(const StepState& found) {
    bool refines = false;
    with(engine_, [&](auto& phase) { refines = phase.must_refine(found); });
    return refines;
  }
  void finish(const StepState& found, FrameCounts& counts) {
    with(engine_, [&](auto& phase) { phase.finish(found, counts); });
  }

  void release() {
    for_each([](auto& phase) { phase.release(); });
  }
  /// Gives back the memory of engines that are idle: is_idle(engine).
  template <class IsIdle>
  void release_idle(const IsIdle& is_idle) {
    for_each([&](auto& phase) {
      if (phase.holds_memory() && is_idle(phase.kEngine)) phase.release();
    });
  }

 private:
  static constexpr size_t kCount = std::tuple_size_v<Table>;

  template <size_t... row>
  Engines(const StepContext<Exec, Real>& context, std::index_sequence<row...>) : table_((void(row), context)...) {
    static_assert((BroadPhase<std::tuple_element_t<row, Table>> && ...));
    static_assert(each_engine_has_a_row<std::tuple_element_t<row, Table>...>(),
                  "frames of an engine without a row would find nothing");
  }

  /// Of its own: kAuto is none that searches.
  template <class... Phase>
  static constexpr bool each_engine_has_a_row() {
    for (int engine = 0; engine <= static_cast<int>(kLastEngine); ++engine) {
      const int rows = (static_cast<int>(Phase::serves(static_cast<Engine>(engine))) + ...);
      if (rows != (static_cast<Engine>(engine) == Engine::kAuto ? 0 : 1)) return false;
    }
    return true;
  }
  template <class Use>
  void for_each(const Use& use) {
    std::apply([&](auto&... phase) { (use(phase), ...); }, table_);
  }
  /// use(phase) with the one that serves the engine.
  template <class Use>
  void with(Engine engine, const Use& use) {
    for_each([&](auto& phase) {
      if (phase.serves(engine)) use(phase);
    });
  }

  Table table_;
  Engine engine_ = Engine::kOctree;  ///< of the step in work
};

}  // namespace collided
