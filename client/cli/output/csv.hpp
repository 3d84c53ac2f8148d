#pragma once
// Contacts as CSV: vertex-triangle, edge-edge, then triangle-triangle rows, in the order of the daemon. Flags are
// words, such as "certified|initial".

#include <string>

#include "client/cpp/frame_stream.hpp"

namespace collided::cli {

/// To a file or, under the name "-", to standard output. Throws std::runtime_error if that cannot be written. Doubles
/// are the shortest that read back the same.
void write_csv(const std::string& file, const client::FrameOutput& output);

}  // namespace collided::cli
