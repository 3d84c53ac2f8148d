#pragma once
// One phase of a run: all streams send by a plan, and what becomes of their frames is counted.

#include <functional>
#include <optional>
#include <vector>

#include "client/measure/load/drive/stream_pace.hpp"
#include "client/measure/load/tally/tally.hpp"

namespace collided::cli::load {

class Fleet;

/// Open loop by `profile`, or closed loop for `seconds`, or until every stream has sent `max_frames`.
struct PhasePlan {
  const RateProfile* profile = nullptr;  ///< of each stream
  Arrivals arrivals = Arrivals::kFixed;
  uint64_t seed = 1;
  double seconds = 0;
  double drain_seconds = 5;  ///< wait at the end for frames that are overdue or unanswered
};

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

using OnSecond = std::function<void(const SeriesPoint&)>;

/// Ends early if it is interrupted, or if all streams have ended.
PhaseResult run_phase(Fleet& fleet, const PhasePlan& plan, const OnSecond& on_second = {});

/// Sends the first `frames` of each stream, few streams at a time. Throws std::runtime_error if a frame is refused or
/// never answered, and Interrupted.
void warm_up(Fleet& fleet, uint32_t frames);

/// Waits until every stream has all answers to what it has sent. False if that takes too long, or is interrupted.
bool settle(const Fleet& fleet);

}  // namespace collided::cli::load
