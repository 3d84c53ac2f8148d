#pragma once
// Runs a step on the backend, in one go or by parts, and again where its lists were too short. A step for which memory
// was allocated will never be the same again: it runs by parts, so that only the last part is repeated where a list was
// too short. The same holds for a step that would have to wait for the recordings of others. On CPU cores every step
// runs by parts.

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

  /// Begins a frame, nothing of which has run.
  void begin() { has_begun_ = false, replays_ = 0; }
  /// Allocates the states. The second is a copy of the first from before a part, the third one from before a search at
  /// kAnyHit.
  void reserve() {
    constexpr uint64_t kStates = 3;
    if (states_.capacity() > 0) return;
    states_.allocate(kStates);
    exec_.fill_zero(states_.data(), kStates * sizeof(StepState));
  }

  /// Sets the number of the next step (PlanNumbers). Steps of the same number do the same work.
  void plan(uint64_t number) {
    number_ = number;
    by_parts_ = !Exec::kLaunchesCost || exec_.allocations() > 0 || !exec_.can_step(number);
  }
  uint64_t number() const { return number_; }
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

  /// Runs a part of the step, and again as long as `must_rerun`, which makes room for what it asked for, says so. Where
  /// the step runs in one go, it only enqueues the part.
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
  /// Says that the counters are the step's own from here on.
  void mark_begun() { has_begun_ = true; }
  bool has_begun() const { return has_begun_; }

  // Of steps by parts: several parts may run again together.
  void save() { exec_.copy(states_.data() + 2, states_.data(), sizeof(StepState)); }
  void restore() {
    exec_.copy(states_.data(), states_.data() + 2, sizeof(StepState));
    ++replays_;
  }

  /// Returns what the step has found; where it runs by parts, so far.
  const StepState& found() const { return found_; }
  StepState& found() { return found_; }
  /// Returns the same, read from the backend now.
  StepState peek() { return exec_.peek(states_.data()); }
  /// Returns how often all or a part of the frame's step ran again.
  uint64_t replays() const { return replays_; }

 private:
  Exec& exec_;
  Buffer<StepState, Exec>& states_;
  StepState found_{};
  uint64_t number_ = 0, replays_ = 0;
  bool by_parts_ = false, has_begun_ = false;
};

}  // namespace collided
