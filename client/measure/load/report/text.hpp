#pragma once
// A load's report for people.

#include <string>

#include "client/cli/report/json.hpp"
#include "client/measure/load/tally/tally.hpp"

namespace collided::cli::load {

/// Of an outcome_json().
std::string outcome_text(const Json& outcome);

/// The progress line of a second.
std::string second_text(const SeriesPoint& point, double previous);

}  // namespace collided::cli::load
