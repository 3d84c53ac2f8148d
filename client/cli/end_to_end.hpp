#pragma once
// collidectl bench --end-to-end: the time of whole frames, from positions in the caller's memory to contacts in the
// caller's memory, over every transport of the daemon, beside the same bytes over bare sockets.

#include "client/cli/bench_run.hpp"

namespace collided::cli {

struct EndToEndOptions {
  BenchSettings settings;
  std::string scene = "cloth_ball";
  double scale = 1;
  std::vector<double> megabytes{1, 5};  ///< more runs: the scene in the scale whose positions are about as large
  std::string out;                      ///< JSON file for all runs; empty: none; "-": standard output
  bool json = false;                    ///< the same to standard output, instead of the table
};

/// Measures and prints, run by run. Starts a daemon of its own.
void run_end_to_end(const EndToEndOptions& options);

/// The scale of a scene whose positions come nearest to so many million bytes a frame. Throws std::invalid_argument as
/// scenes::check_scene, and if the scene cannot be made as large or as small.
double scale_for(const std::string& scene, double megabytes, v1::PositionFormat format);

}  // namespace collided::cli
