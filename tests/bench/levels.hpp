#pragma once
// The cost of the accuracy levels and reports, side by side: every step runs each of them in turn, so that other load
// on the machine affects all alike.

#include <iosfwd>

#include "tests/bench/inputs.hpp"

namespace collided::test {

struct LevelRun {
  std::string name;      ///< such as "certified" or "certified any"
  double narrow_ms = 0;  ///< narrow phase: sum over the steps of the best of the repeats
  double total_ms = 0;   ///< all stages, likewise
  uint64_t contacts = 0;
};

struct LevelReport {
  std::string scene;
  uint64_t triangles = 0;
  std::vector<LevelRun> runs;
};

/// `spec` gives backend, mode, scalar, thickness and threads.
LevelReport compare_levels(const BenchInput& input, const SceneSpec& spec, int steps, int repeats);

void write_levels(std::ostream& out, const std::vector<LevelReport>& reports);

}  // namespace collided::test
