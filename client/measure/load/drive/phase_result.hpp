#pragma once
// What a phase of a run measured.

#include <vector>

#include "client/measure/load/tally/tally.hpp"

namespace collided::cli::load {

/// What the tester itself took.
struct Cost {
  double cpu_seconds = 0;     ///< of the process
  double busiest_thread = 0;  ///< CPU time of the thread that worked most, as a part of the time that passed
};

struct PhaseResult {
  double seconds = 0;  ///< until the last answer, or until it gave up
  Tally tally;
  std::vector<SeriesPoint> series;
  Cost cost;
  RefusalsByCode ended;  ///< streams that ended early
  bool is_interrupted = false;
};

}  // namespace collided::cli::load
