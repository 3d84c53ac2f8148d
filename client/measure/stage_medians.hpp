#pragma once
// Median times of stages over several frames.

#include <vector>

#include "client/app/report/json.hpp"

namespace collided::cli {

/// Milliseconds of every stage, and of the whole frame ("total").
Json median_stages(const std::vector<v1::FrameMetrics>& frames);

}  // namespace collided::cli
