#pragma once
// The benchmark's inputs: procedural scenes stepping through time, and repeated pairs of real frames.

#include <functional>
#include <utility>
#include <vector>

#include "tests/support/case.hpp"

namespace collided::test {

struct BenchInput {
  std::string name;
  std::function<Case(int step, int steps)> at;  ///< meshes and positions of one step
};

struct Play {
  int steps = 20, warm_up = 2;
  bool in_slot = false;  ///< positions lie in a slot's memory before a step begins, where the daemon decodes them to
};

/// The frame with its positions in the slot's memory.
FrameInput moved_to_slot(const FrameInput& frame, FrameSlot& slot);

/// Plays the steps of an input to a detector, after those to warm up, in which buffers grow to the size of the hardest
/// step. use(play): each step, where play() has the detector answer and returns its result.
template <class Use>
void play_steps(Detector& detector, const BenchInput& input, const SceneSpec& spec, const Play& how, const Use& use) {
  const auto slot = how.in_slot ? detector.make_slot() : nullptr;
  const auto [steps, warm_up] = std::pair(how.steps, how.warm_up);
  for (int i = -warm_up; i < steps; ++i) {
    const bool is_first = i == -warm_up;
    const Case c = input.at(i >= 0 ? i : is_first ? 0 : steps - 1, steps);
    const Frame frame(c, spec.mode, spec.scalar, is_first);
    const FrameInput ready = slot ? moved_to_slot(frame.input(), *slot) : frame.input();
    const auto play = [&] {
      if (!slot) return detector.detect(ready);
      slot->send(ready.updates);
      return detector.detect({.updates = {}, .slot = slot});
    };
    i < 0 ? static_cast<void>(play()) : use(play);
  }
}

inline constexpr double kFrameSeconds = 1.0 / 60;

/// All inputs, or the one of that name, which may be a variant of a scene. Real frames only where the data folder is
/// present. `seconds`: how long procedural scenes move in a step.
std::vector<BenchInput> bench_inputs(const std::string& only, double scale, double seconds = kFrameSeconds);

}  // namespace collided::test
