#pragma once
// How the backend runs a step: in one go, or by parts, and again where it was short of room. A step that will not be as
// it is again, because memory was allocated for it, runs by parts: where it was short of room only the last part runs
// again. So does one that would have to wait for recordings of others. On CPU cores all do.

#include <utility>

#include "gpu/exec/buffer.hpp"
#include "gpu/exec/concepts.hpp"
#include "gpu/state/state.hpp"

namespace collided {

template <Executor Exec>
class StepRun {
 public:
  /// `states`: of the scene; outlives the run.
  StepRun(Exec& exec, Buffer<StepState, Exec>& states) : exec_(exec), states_(states) {}

  /// A frame begins: nothing of it has run.
  void begin() { has_begun_ = false, replays_ = 0; }
  /// The second state is what the first was before a part, the third what it was before a search at kAnyHit.
  void reserve() {
    constexpr uint64_t kStates = 3;
    if (states_.capacity() > 0) return;
    states_.allocate(kStates);
    exec_.fill_zero(states_.data(), kStates * sizeof(StepState));
  }

  /// The next step has this number (PlanNumbers). Steps of the same number do the same work.
  void plan(uint64_t number) {
    number_ = number;
    by_parts_ = !Exec::kLaunchesCost || exec_.allocations() > 0 || !exec_.can_step(number);
  }
  bool is_by_parts() const { return by_parts_; }
  /// Runs the step once: enqueue() hands all of it to the backend. Returns false if it ran in one go and must_rerun().
  template <class Enqueue, class MustRerun>
  bool run(const Enqueue& enqueue, const MustRerun& must_rerun) {
    if (by_parts_) {
      found_ = exec_.step_by_parts(states_.data(), enqueue);
      return true;
    }
    has_begun_ = true;
    found_ = exec_.step(number_, states_.data(), enqueue);
    if (!must_rerun()) return true;
    ++replays_;
    return false;
  }

  /// A part of the step. After it, where steps run by parts, `must_rerun` makes room for what it asked for.
  template <class Put, class MustRerun>
  void part(const Put& put, const MustRerun& must_rerun) {
    if (!by_parts_) return put();
    StepState* state = states_.data();
    exec_.copy(state + 1, state, sizeof(StepState));
    for (;;) {
      put();
      found_ = exec_.peek(state);
      if (!must_rerun()) return;
      ++replays_;
      exec_.copy(state, state + 1, sizeof(StepState));
    }
  }
  /// From here on the counters are the step's own.
  void mark_begun() { has_begun_ = true; }
  bool has_begun() const { return has_begun_; }

  // Of steps by parts: several parts may run again together.
  void save() { exec_.copy(states_.data() + 2, states_.data(), sizeof(StepState)); }
  void restore() {
    exec_.copy(states_.data(), states_.data() + 2, sizeof(StepState));
    ++replays_;
  }

  /// What the step has found; where it runs by parts, so far.
  const StepState& found() const { return found_; }
  StepState& found() { return found_; }
  /// The same, read from the backend now.
  StepState peek() { return exec_.peek(states_.data()); }
  /// How often all or a part of the frame's step ran again.
  uint64_t replays() const { return replays_; }

 private:
  Exec& exec_;
  Buffer<StepState, Exec>& states_;
  StepState found_{};
  uint64_t number_ = 0, replays_ = 0;
  bool by_parts_ = false, has_begun_ = false;
};

}  // namespace collided
