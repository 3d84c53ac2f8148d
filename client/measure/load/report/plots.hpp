#pragma once
// The charts of a load's report.

#include <vector>

#include "client/app/report/json.hpp"
#include "client/measure/load/report/chart.hpp"

namespace collided::cli::load {

/// Of an outcome_json(): latency by percentile and over time, frames over time, and the trials of --find-max, as far as
/// there is something to show.
std::vector<Chart> plots_of(const Json& outcome);

}  // namespace collided::cli::load
