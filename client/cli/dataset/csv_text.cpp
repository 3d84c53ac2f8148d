// Cells of CSV that hold text.

#include "client/cli/dataset/csv_text.hpp"

#include <stdexcept>

namespace collided::cli {

namespace {

/// Removes a cell in quotes from the front of `line`.
std::string take_quoted(std::string_view& line) {
  std::string cell;
  for (size_t at = 1; at < line.size(); ++at) {
    if (line[at] != '"') {
      cell += line[at];
    } else if (at + 1 < line.size() && line[at + 1] == '"') {
      cell += line[at++];
    } else {
      line.remove_prefix(at + 1);
      if (!line.empty() && line.front() != ',') throw std::runtime_error("text after quotes");
      return cell;
    }
  }
  throw std::runtime_error("quotes that do not end");
}

}  // namespace

std::string csv_cell(std::string_view text) {
  const bool is_like_comment = text.starts_with('#');
  if (!is_like_comment && text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string cell = "\"";
  for (const char c : text) cell.append(c == '"' ? 2 : 1, c);
  return cell + "\"";
}

std::vector<std::string> csv_cells(std::string_view line) {
  std::vector<std::string> cells;
  for (;;) {
    if (line.starts_with('"')) {
      cells.push_back(take_quoted(line));
    } else {
      cells.emplace_back(line.substr(0, line.find(',')));
      line.remove_prefix(cells.back().size());
    }
    if (line.empty()) return cells;
    line.remove_prefix(1);
  }
}

}  // namespace collided::cli
