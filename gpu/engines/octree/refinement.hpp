#pragma once
// When the octree goes on below its dense levels. Most scenes need none of that and pay nothing for it; where crowded
// cells at the lowest level make too many tests, the step is given up before it makes them and runs again with bricks.

#include "gpu/engines/octree/leaf_pairs.hpp"
#include "gpu/state/state.hpp"

namespace collided {

class Refinement {
 public:
  int rounds() const { return rounds_; }
  /// Tests of crowded cells at the lowest level that a step may make for each triangle with a box; more put it off.
  uint64_t limit() const { return may_refine() ? 512 : kAnyNumberOfTests; }

  /// Looks at a step that ran; whether it has to run again, with more rounds.
  bool observe(const StepState& step) {
    const bool reruns = step.leaves[LeafSum::kCrowdedTests] > limit() * step.totals.boxed();
    if (reruns) {
      tests_before_ = step.leaves[LeafSum::kTests];
      rounds_before_ = rounds_;
      rounds_ = kMaxRounds;
      return true;
    }
    if (tests_before_ != 0 && step.leaves[LeafSum::kTests] > tests_before_ / 4 * 3) {
      rounds_ = rounds_before_;  // crowded for good: everything touches everything
      frames_to_wait_ = kFramesToWait;
    } else {
      while (rounds_ > 0 && step.bricks[rounds_ - 1] == 0) --rounds_;
    }
    tests_before_ = 0;
    if (frames_to_wait_ > 0) --frames_to_wait_;
    return false;
  }

 private:
  static constexpr int kFramesToWait = 256;
  bool may_refine() const { return rounds_ < kMaxRounds && frames_to_wait_ == 0; }

  int rounds_ = 0, rounds_before_ = 0;
  uint64_t tests_before_ = 0;  ///< of the run of this frame that was put off
  int frames_to_wait_ = 0;     ///< before refinement is tried again
};

}  // namespace collided
