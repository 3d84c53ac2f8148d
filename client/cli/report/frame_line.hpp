#pragma once
// One answered frame of many: a line for people, or an object.

#include "client/cli/report/json.hpp"

namespace collided::cli {

/// "12 contacts (3 vt, 9 ee, 0 tt), earliest 0.25, 1.234 ms"; with REPORT_ANY_HIT, which counts none, "a contact" or
/// "no contact".
std::string frame_text(const v1::FrameDone& done, v1::Report report);

/// Contacts, as far as they were counted, and what frame_json tells.
Json frame_result_json(const v1::FrameDone& done, v1::Report report);

}  // namespace collided::cli
