#pragma once
// A load's report as one HTML page that needs no other file.

#include <string>

#include "client/app/report/json.hpp"

namespace collided::cli::load {

/// Of an outcome_json().
std::string outcome_html(const Json& outcome);

}  // namespace collided::cli::load
