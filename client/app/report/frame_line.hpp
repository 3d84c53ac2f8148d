#pragma once
// One answered frame of many: a line for people, or an object.

#include "client/app/report/json.hpp"

namespace collided::cli {

// A frame may have asked for another mode and accuracy than its scene's spec. It does not tell, but candidates are no
// contacts, and so show.

/// Whether the frame found times of impact: in DCD, of candidates and with REPORT_ANY_HIT there are none.
bool has_times(const v1::FrameDone& done, const v1::SceneSpec& spec);

/// How many contacts of each kind the frame found, or candidates if its accuracy is CANDIDATES.
client::PerKind<uint64_t> found_counts(const v1::FrameDone& done, const v1::SceneSpec& spec);

/// "12 contacts (3 vt, 9 ee, 0 tt), earliest 0.25, 1.234 ms", or "12 candidates", without a time where there is none;
/// with REPORT_ANY_HIT, which counts none, "a contact" or "no contact".
std::string frame_text(const v1::FrameDone& done, const v1::SceneSpec& spec);

/// Returns ", went 0.93 of its way, 12 vertices shortened, 5 contacts limit it" for a frame with `advance`, and "" for
/// others. The second part is there if the frame advanced per mesh or per vertex, the third if contacts that limit its
/// way came.
std::string advance_text(const client::FrameOutput& output);

/// Counts what did not go all of its way in a frame that advanced per mesh or per vertex, and the contacts that limit
/// the way if any came.
Json advance_json(const client::FrameOutput& output);

/// Contacts and their earliest time, as far as they were counted, and how far the frame went.
Json found_json(const v1::FrameDone& done, const v1::SceneSpec& spec);

/// The same, and what frame_json tells.
Json frame_result_json(const v1::FrameDone& done, const v1::SceneSpec& spec);

}  // namespace collided::cli
