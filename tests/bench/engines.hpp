#pragma once
// Tests and registrations of each engine, step by step. These are counts: the same on every backend.

#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/inputs.hpp"

namespace collided::test {

struct EngineRun {
  std::string scene, engine;
  uint64_t triangles = 0;
  std::vector<FrameCounts> steps;
};

using NamedEngine = std::pair<std::string, Engine>;

/// The steps of one input, after a warm-up, with each engine in turn. `spec` gives the rest. Throws std::runtime_error
/// if two engines find different numbers of pairs.
std::vector<EngineRun> compare_engines(const BenchInput& input, SceneSpec spec, const std::vector<NamedEngine>& engines,
                                       int steps, int warm_up);

/// As client/measure/plot reads them: `counts` are means over the steps.
void write_engines(std::ostream& out, const std::vector<EngineRun>& runs);

}  // namespace collided::test
