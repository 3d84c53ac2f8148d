#pragma once
// One contact in words.

#include <optional>
#include <string_view>
#include <vector>

#include "client/cli/report/json.hpp"

namespace collided::cli {

/// "certified", "near", "capped", "initial": those that are set.
std::vector<std::string_view> flag_words(uint8_t flags);

/// The contact of the earliest time of impact, the first one of several: kind, elements, stencil, toi, distance and
/// flags, as far as there are. Nothing if no contact has a time.
std::optional<Json> earliest_contact(const client::FrameOutput& output);

}  // namespace collided::cli
