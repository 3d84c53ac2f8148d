#pragma once
// Results of 'collidectl tradeoff' as JSON.

#include "client/app/report/json.hpp"
#include "client/measure/tradeoff/result.hpp"

namespace collided::cli {

/// The whole file, which client/measure/plot draws. Its "format" is "collided tradeoff 1".
Json tradeoff_json(const Tradeoff& result);

/// Missed and false contacts and the times of each run.
Json tradeoff_summary(const Tradeoff& result);

}  // namespace collided::cli
