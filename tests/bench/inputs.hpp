#pragma once
// The benchmark's inputs: procedural scenes stepping through time, and repeated pairs of real frames.

#include <functional>
#include <vector>

#include "tests/support/case.hpp"

namespace collided::test {

struct BenchInput {
  std::string name;
  std::function<Case(int step, int steps)> at;  ///< meshes and positions of one step
};

/// Plays the steps of an input to a detector, after `warm_up` of them, in which buffers grow to the size of the hardest
/// step. use(play): each step, where play() has the detector answer and returns its result.
template <class Use>
void play_steps(Detector& detector, const BenchInput& input, const SceneSpec& spec, int steps, int warm_up,
                const Use& use) {
  for (int i = -warm_up; i < steps; ++i) {
    const bool is_first = i == -warm_up;
    const Case c = input.at(i >= 0 ? i : is_first ? 0 : steps - 1, steps);
    const Frame frame(c, spec.mode, spec.scalar, is_first);
    const auto play = [&] { return detector.detect(frame.input()); };
    i < 0 ? static_cast<void>(play()) : use(play);
  }
}

/// All inputs, or the one of that name, which may be a variant of a scene. Real frames only where the data folder is
/// present.
std::vector<BenchInput> bench_inputs(const std::string& only, double scale);

}  // namespace collided::test
