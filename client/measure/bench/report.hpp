#pragma once
// Results of 'collidectl bench' as JSON and as a table.

#include <exception>
#include <string>
#include <vector>

#include "client/app/report/json.hpp"

namespace collided::cli {

/// One input with one engine.
struct BenchRun {
  std::string name;                          ///< of the input
  v1::Scene scene;                           ///< after the last step
  std::vector<v1::FrameMetrics> steps;       ///< without the warm-up, in their order; 1 or more
  std::exception_ptr interrupted = nullptr;  ///< why the run ended early, if it did
};

/// Times are in milliseconds. Counts are those of the last step, except "replays" and "steps_by_engine", which are
/// sums.
Json run_json(const BenchRun& run);

/// The whole file: {"device", "settings", "runs"}, with the settings that all runs share. There must be a run; `scale`
/// is null for mesh files.
Json bench_json(const std::vector<BenchRun>& runs, int warm_up, const Json& scale);

/// The table's head, and the lines of a run_json(): times, then stages, counts and memory.
std::string bench_head();
std::string bench_lines(const Json& run);

}  // namespace collided::cli
