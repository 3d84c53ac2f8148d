#pragma once
// Merges stages of a frame that are reported as one.

#include <algorithm>
#include <vector>

#include "gpu/types.hpp"

namespace collided {

/// Replaces stages [first, end) by one with the sum of their times.
inline void make_one_stage(std::vector<StageTime>& stages, size_t first, size_t end, const char* name) {
  StageTime all{name, 0};
  for (size_t i = first; i < end; ++i) all.milliseconds += stages[i].milliseconds;
  const auto at = stages.begin() + static_cast<std::ptrdiff_t>(first);
  stages.insert(stages.erase(at, at + static_cast<std::ptrdiff_t>(end - first)), all);
}

/// Replaces all stages of a name by one at the end, with the sum of their times.
inline void gather_stages(std::vector<StageTime>& stages, const char* name) {
  const auto others =
      std::stable_partition(stages.begin(), stages.end(), [&](const StageTime& s) { return s.stage != name; });
  make_one_stage(stages, static_cast<size_t>(others - stages.begin()), stages.size(), name);
}

}  // namespace collided
