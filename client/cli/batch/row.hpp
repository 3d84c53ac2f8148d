#pragma once
// A pair of frames in the table of all pairs: what was found, or why nothing was.

#include <string>

#include "client/cli/batch/record.hpp"
#include "client/cli/dataset/dataset.hpp"
#include "client/cpp/frame_stream.hpp"

namespace collided::cli {

/// The table's first line.
extern const char* const kRowHeader;

/// The row with its line break. It depends on the frames and the options alone.
std::string row_of(uint64_t pair, const FrameNames& names, const v1::Scene& scene, const client::FrameOutput& output);
std::string failed_row(uint64_t pair, const FrameNames& names, const std::string& why);

/// A record whose text is the row, followed by the contacts' rows.
Record pair_record(std::string row, const std::string& contacts);
/// Of such a record. Throws std::runtime_error, without a place, if it is none.
std::string_view row_in(const Record& record);
std::string_view contacts_in(const Record& record);

}  // namespace collided::cli
