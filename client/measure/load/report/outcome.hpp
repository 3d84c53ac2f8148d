#pragma once
// What a load measured, and how it is reported as JSON.

#include <optional>
#include <string>
#include <vector>

#include "client/app/report/json.hpp"
#include "client/measure/load/daemon/counters.hpp"
#include "client/measure/load/drive/phase_run.hpp"
#include "client/measure/load/settings.hpp"

namespace collided::cli::load {

/// One rate that --find-max tried, of all streams together.
struct Trial {
  double rate = 0;
  std::string failure;  ///< why it did not hold; empty: it did
  double p50 = 0, p99 = 0, max = 0;
  uint64_t answered = 0;
};

/// One run of several on the same daemon, each with scenes of its own.
struct Generation {
  double setup_seconds = 0;  ///< to create the scenes and open the streams
  double p50 = 0, p99 = 0, max = 0;
  uint64_t answered = 0;
};

struct Outcome {
  std::string input;    ///< what was played
  std::string version;  ///< of the daemon
  std::string host;     ///< that the tester ran on
  std::string date;     ///< when it ended: UTC, ISO 8601
  v1::Scene scene;      ///< one of them
  uint64_t bytes_per_frame = 0;
  size_t connections = 0, threads = 0;
  PhaseResult result;                   ///< the last run, or the best trial
  std::vector<Generation> generations;  ///< all runs, in order
  std::vector<Trial> trials;            ///< of --find-max
  std::optional<double> best;           ///< the highest rate that held
  std::optional<Samples> daemon;        ///< what was added to the daemon's counters in the whole run
  Tally counted;                        ///< what the tester counted in that time, all trials together
};

/// Whether the tester itself was too slow or too late for its figures to be the daemon's.
bool is_tester_slow(const PhaseResult& result);

/// What a reader of the figures should know: streams that ended, a tester that was itself too slow, counts that differ
/// from the daemon's.
std::vector<std::string> warnings_of(const LoadSettings& settings, const Outcome& outcome);

Json outcome_json(const LoadSettings& settings, const Outcome& outcome);

}  // namespace collided::cli::load
