#pragma once
// One contact for people and as JSON.

#include <optional>
#include <string_view>
#include <vector>

#include "client/app/report/json.hpp"

namespace collided::cli {

/// Returns the words of the flags that are set, such as "certified" and "touching".
std::vector<std::string_view> flag_words(uint8_t flags);

/// Returns the words of a contact's `features`. The first two locate the closest points, such as "vertex" and "side_1",
/// or "inside" and "end_2". Those of "nearer_at_first", "nearer_at_second" and "same_as_before" that hold follow.
/// Returns nothing for kinds without features.
std::vector<std::string_view> feature_words(v1::ContactKind kind, uint8_t features);

/// Counts the contacts that others cover. Returns nothing if no contact has `features`: then it is not known.
std::optional<uint64_t> count_covered(const client::FrameOutput& output);

/// Removes the contacts that others cover.
void leave_out_covered(client::FrameOutput& output);

/// Returns kind, elements, stencil, toi, distance and flags of contact `i`, as far as they were computed.
Json contact_json(const std::string& kind, const client::Contacts& contacts, size_t i);

/// The contact with the earliest time of impact (the first of several): kind, elements, stencil, toi, distance and
/// flags, as far as they were computed. Nothing if no contact has a time.
std::optional<Json> earliest_contact(const client::FrameOutput& output);

}  // namespace collided::cli
