#pragma once
// Plays inputs on a daemon, engine by engine, and keeps what the frames cost.

#include "client/cli/daemon/connection.hpp"
#include "client/measure/bench/input.hpp"
#include "client/measure/bench/report.hpp"
#include "client/measure/bench/settings.hpp"

namespace collided::cli {

/// One input with the engine of the settings, on a scene of its own, one frame in flight: a frame's time is not to
/// depend on its neighbours. An interrupt leaves a run of the steps so far, and itself in it.
BenchRun measure(Connection& connection, const BenchSettings& settings, const BenchInput& input);

}  // namespace collided::cli
