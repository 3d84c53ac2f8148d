#pragma once
// Contacts as CSV: vertex-triangle, edge-edge, then triangle-triangle rows, each in the daemon's order. Flags are
// words, such as "certified|initial"; a field that was not computed is empty.

#include <string>

#include "client/cli/output/contact_points.hpp"

namespace collided::cli {

/// Writes to a file, or to standard output if its name is "-". Throws std::runtime_error if the file cannot be written.
void write_csv(const std::string& file, const client::FrameOutput& output, const StepPositions& positions);

}  // namespace collided::cli
