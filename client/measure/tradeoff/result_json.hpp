#pragma once
// What 'collidectl tradeoff' found, as JSON.

#include "client/cli/report/json.hpp"
#include "client/measure/tradeoff/result.hpp"

namespace collided::cli {

/// All of it, with "format": "collided tradeoff 1". client/measure/plot draws it.
Json tradeoff_json(const Tradeoff& result);

/// Missed and false contacts and the times of each run.
Json tradeoff_summary(const Tradeoff& result);

}  // namespace collided::cli
