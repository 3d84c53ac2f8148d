#pragma once
// collidectl load: drives a daemon with many streams, and reports the latency of each frame.

#include "client/measure/load/settings.hpp"

namespace collided::cli::load {

/// Prints and writes what the settings ask for; also what was measured before something ended it. Throws Interrupted
/// after an interrupt, std::runtime_error if streams ended early.
void run_load(const LoadSettings& settings);

}  // namespace collided::cli::load
