#pragma once
// The cost of one scene, as JSON, and what results of every kind name.

#include <iosfwd>
#include <string>

#include "tests/support/case.hpp"

namespace collided::test {

struct SceneReport {
  std::string name;
  uint64_t triangles = 0, device_bytes = 0, digest = 0;
  int steps = 0;
  uint32_t replays = 0;
  FrameCounts counts;                                    ///< of the last step
  std::vector<std::pair<std::string, double>> stage_ms;  ///< medians, in the order of the pipeline
  double total_ms = 0;                                   ///< median of the sum of a step's stages
  double wall_ms = 0;                                    ///< median of detect(), including transfers
};

struct RunReport {
  std::string date, commit, device, mode, accuracy, scalar;
  double thickness = 0;
  std::string positions;  ///< where they lie before a step
  std::vector<SceneReport> scenes;
};

/// Of the device that scenes of a backend are on; 0 threads: all cores. Throws std::runtime_error if there is none.
std::string device_name(Backend backend, int threads = 0);
double median(std::vector<double> values);
void write_json(std::ostream& out, const RunReport& report);

}  // namespace collided::test
