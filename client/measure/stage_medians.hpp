#pragma once
// What the stages of several frames took.

#include <vector>

#include "client/cli/report/json.hpp"

namespace collided::cli {

/// Medians, over the frames, of every stage and of the total ("total").
Json median_stages(const std::vector<v1::FrameMetrics>& frames);

}  // namespace collided::cli
