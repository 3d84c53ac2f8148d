#pragma once
// What the benchmark runs: procedural scenes stepping through time, and pairs of real frames again and again.

#include <functional>
#include <vector>

#include "tests/support/case.hpp"

namespace collided::test {

struct BenchInput {
  std::string name;
  std::function<Case(int step, int steps)> at;  ///< meshes and positions of one step
};

/// All inputs, or the one of that name, which may be a variant of a scene. Real frames only where the data folder is
/// present.
std::vector<BenchInput> bench_inputs(const std::string& only, double scale);

}  // namespace collided::test
