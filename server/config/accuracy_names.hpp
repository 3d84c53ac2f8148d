#pragma once
// Accuracy levels as options name them.

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gpu/detector.hpp"

namespace collided::server {

/// In the order of the levels.
inline constexpr std::array<std::string_view, 5> kAccuracyNames = {"candidates", "fast", "guarded", "certified",
                                                                   "exact"};

inline std::vector<std::string> accuracy_names() { return {kAccuracyNames.begin(), kAccuracyNames.end()}; }

inline std::string name_of(Accuracy accuracy) { return std::string(kAccuracyNames.at(static_cast<size_t>(accuracy))); }

/// nullopt for an unknown name.
inline std::optional<Accuracy> accuracy_named(std::string_view name) {
  const auto found = std::ranges::find(kAccuracyNames, name);
  if (found == kAccuracyNames.end()) return {};
  return static_cast<Accuracy>(found - kAccuracyNames.begin());
}

}  // namespace collided::server
