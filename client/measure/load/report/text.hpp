#pragma once
// A load's report for people.

#include <string>
#include <utility>
#include <vector>

#include "client/app/report/json.hpp"
#include "client/measure/load/tally/tally.hpp"

namespace collided::cli::load {

/// Of an outcome_json(): who sent what, and how; and the whole report.
std::string load_text(const Json& outcome);
std::string outcome_text(const Json& outcome);

/// What was timed, and its times, in the order of the report's rows.
std::vector<std::pair<std::string, Json>> timed(const Json& outcome);

/// The progress line of a second.
std::string second_text(const SeriesPoint& point);

}  // namespace collided::cli::load
