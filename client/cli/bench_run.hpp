#pragma once
// Plays inputs on a daemon, engine by engine, and keeps what the frames cost.

#include "client/cli/bench_input.hpp"
#include "client/cli/bench_report.hpp"
#include "client/cli/connection.hpp"

namespace collided::cli {

struct BenchSettings {
  ServerOptions server;
  DetectionOptions detection;
  std::string position_format = "f32";
  int steps = 50;
  int warm_up = 10;  ///< steps before those that count
};

/// One input with the engine of the settings, on a scene of its own, one frame in flight: a frame's time is not to
/// depend on its neighbours. An interrupt leaves a run of the steps so far, and itself in it.
BenchRun measure(Connection& connection, const BenchSettings& settings, const BenchInput& input);

}  // namespace collided::cli
