#pragma once
// Plays an input on a daemon and records the cost of its frames.

#include "client/app/daemon/connection.hpp"
#include "client/measure/bench/input.hpp"
#include "client/measure/bench/report.hpp"
#include "client/measure/bench/settings.hpp"

namespace collided::cli {

/// Plays one input with the settings' engine, on its own scene, with one frame in flight so that no frame's time
/// depends on its neighbours. After an interrupt the run has the steps so far and the interrupt.
BenchRun measure(Connection& connection, const BenchSettings& settings, const BenchInput& input);

}  // namespace collided::cli
