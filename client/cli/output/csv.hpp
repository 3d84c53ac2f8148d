#pragma once
// Contacts as CSV: vertex-triangle, edge-edge, then triangle-triangle rows, each in the daemon's order. Flags are
// words, such as "certified|initial".

#include <string>

#include "client/cpp/frame_stream.hpp"

namespace collided::cli {

/// Writes to a file, or to standard output if its name is "-". Doubles are written in the fewest digits that read back
/// the same. Throws std::runtime_error if the file cannot be written.
void write_csv(const std::string& file, const client::FrameOutput& output);

}  // namespace collided::cli
