#pragma once
// The daemon's own counters before and after a run, beside what the tester counted.

#include <map>
#include <string>

#include "client/app/report/json.hpp"
#include "client/measure/load/tally/tally.hpp"

namespace collided::cli::load {

/// Samples of Prometheus' text format, by name with labels, such as `collided_rejected_total{reason="NOT_FOUND"}`.
using Samples = std::map<std::string, double>;

Samples parse_samples(const std::string& text);
/// What was added from `before` to `after`; samples of which nothing was added are left out.
Samples growth(const Samples& before, const Samples& after);

/// Frames, skipped, rejected by reason, and mean times, as far as there are any.
Json daemon_json(const Samples& growth);

/// How the tester's counts differ from the daemon's.
struct Comparison {
  Json counts;                ///< {"answered": {"tester", "daemon"}, ...}, and the mean time of a frame, likewise
  double max_difference = 0;  ///< of any two of them, as a part of the larger
};
Comparison compare(const Tally& tally, const Samples& growth);

}  // namespace collided::cli::load
