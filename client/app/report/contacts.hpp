#pragma once
// One contact for people and as JSON.

#include <optional>
#include <string_view>
#include <vector>

#include "client/app/report/json.hpp"

namespace collided::cli {

/// Those of "certified", "near", "capped" and "initial" whose flag is set.
std::vector<std::string_view> flag_words(uint8_t flags);

/// The contact with the earliest time of impact (the first of several): kind, elements, stencil, toi, distance and
/// flags, as far as they were computed. Nothing if no contact has a time.
std::optional<Json> earliest_contact(const client::FrameOutput& output);

}  // namespace collided::cli
