#pragma once
// What 'collidectl bench' found, as JSON and as a table.

#include <exception>
#include <string>
#include <vector>

#include "client/cli/report/json.hpp"

namespace collided::cli {

/// One input with one engine.
struct BenchRun {
  std::string name;                          ///< of the input
  v1::Scene scene;                           ///< after the last step
  std::vector<v1::FrameMetrics> steps;       ///< those that count, in their order; 1 or more
  std::exception_ptr interrupted = nullptr;  ///< the run ended before all steps were done
};

/// Times are in milliseconds; counts are those of the last step, but for "replays" and "steps_by_engine", which are of
/// all steps.
Json run_json(const BenchRun& run);

/// The whole file: {"device", "settings", "runs"}. The settings are those that all runs share. There must be a run;
/// `scale` is null for mesh files.
Json bench_json(const std::vector<BenchRun>& runs, int warm_up, const Json& scale);

/// The table's head, and the lines of what run_json gave: times, then stages, counts and memory.
std::string bench_head();
std::string bench_lines(const Json& run);

}  // namespace collided::cli
