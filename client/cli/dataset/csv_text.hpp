#pragma once
// Cells of CSV that hold text (RFC 4180).

#include <string>
#include <string_view>
#include <vector>

namespace collided::cli {

/// In quotes if it needs them, as text that begins with '#' does at the beginning of a line.
std::string csv_cell(std::string_view text);

/// The cells of a line. Throws std::runtime_error, without a place, for quotes that do not end.
std::vector<std::string> csv_cells(std::string_view line);

}  // namespace collided::cli
