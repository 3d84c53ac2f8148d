#pragma once
// One contact for people and as JSON.

#include <optional>
#include <string_view>
#include <vector>

#include "client/app/report/json.hpp"

namespace collided::cli {

/// Returns the words of the flags that are set, such as "certified" and "touching".
std::vector<std::string_view> flag_words(uint8_t flags);

/// Returns kind, elements, stencil, toi, distance and flags of contact `i`, as far as they were computed.
Json contact_json(const std::string& kind, const client::Contacts& contacts, size_t i);

/// The contact with the earliest time of impact (the first of several): kind, elements, stencil, toi, distance and
/// flags, as far as they were computed. Nothing if no contact has a time.
std::optional<Json> earliest_contact(const client::FrameOutput& output);

}  // namespace collided::cli
