#pragma once
// The last frames of a scene as a table for a terminal.

#include <string>
#include <vector>

#include "client/cli/live/history.hpp"

namespace collided::cli {

struct TableSize {
  size_t columns = 80, rows = 24;
  bool has_unicode = true;  ///< else ASCII alone
};

/// What the table is of: two lines, such as the scene's name and what it is made of.
std::vector<std::string> table_title(const v1::Scene& scene);

/// Lines of at most so many columns, and at most so many of them: the title, the rate, and for each figure its last
/// value, the least, the median and the greatest of the last frames, and a curve of them from 0 to the greatest.
std::vector<std::string> table_lines(const std::vector<std::string>& title, const History& history, TableSize size);

/// One character for each of the last `width` values, higher for larger ones.
std::string curve(const std::deque<double>& values, size_t width, bool has_unicode);

}  // namespace collided::cli
