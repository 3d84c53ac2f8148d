#pragma once
// collidectl bench --end-to-end: the time of whole frames, from positions in the caller's memory to contacts in the
// caller's memory, over every transport of the daemon, compared with the same bytes over bare sockets.

#include <string>
#include <vector>

#include "client/measure/bench/settings.hpp"

namespace collided::cli {

struct EndToEndOptions {
  BenchSettings settings;
  std::string scene = "cloth_ball";
  double scale = 1;
  std::vector<double> megabytes{1, 5};  ///< one more run each, at the scale with about that much per frame
  std::string out;                      ///< JSON file of all runs; empty: none; "-": standard output
  bool json = false;                    ///< print the JSON instead of the table
};

/// Measures and prints run by run, with its own daemon.
void run_end_to_end(const EndToEndOptions& options);

}  // namespace collided::cli
