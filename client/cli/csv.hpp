#pragma once
// Contacts as CSV: vertex-triangle, edge-edge, then triangle-triangle rows, in the order of the daemon. Flags are
// words, such as "certified|initial".

#include <filesystem>

#include "client/cpp/frame_stream.hpp"

namespace collided::cli {

/// Throws std::runtime_error if the file cannot be written. Doubles are the shortest that read back the same.
void write_csv(const std::filesystem::path& file, const client::FrameOutput& output);

}  // namespace collided::cli
