#pragma once
// Help texts of all programs: none of their lines is wider than a terminal.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace collided {

inline constexpr size_t kMaxHelpColumns = 100;

/// Breaks a line at blanks so that no row is wider than a terminal; rows after the first are indented.
inline std::string wrapped(std::string_view line, size_t indent) {
  std::string out;
  size_t room = kMaxHelpColumns;
  while (line.size() > room) {
    size_t at = line.rfind(' ', room);
    // A first column wider than the indent, or a word wider than a row, is never broken.
    if (at == std::string_view::npos || at <= line.find_first_not_of(' ')) at = line.find(' ', room);
    if (at == std::string_view::npos) break;
    out.append(line.substr(0, at)).append("\n").append(indent, ' ');
    line.remove_prefix(std::min(line.find_first_not_of(' ', at), line.size()));
    room = kMaxHelpColumns - indent;
  }
  return out.append(line);
}

/// Wraps options below their descriptions, and paragraphs of a footer as a whole.
inline std::string fitted(const std::string& help, size_t option_indent) {
  std::string out, paragraph;
  bool is_wide = false;
  std::vector<std::string> lines;
  const auto end_paragraph = [&] {
    for (const std::string& line : lines) out += is_wide ? "" : line + "\n";
    if (is_wide) out += wrapped(paragraph, 0) + "\n";
    lines.clear(), paragraph.clear(), is_wide = false;
  };
  std::istringstream in(help);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.front() == ' ') {
      end_paragraph();
      out += wrapped(line, line.starts_with("  ") ? option_indent : 0) + "\n";
      continue;
    }
    is_wide = is_wide || line.size() > kMaxHelpColumns;
    paragraph += (paragraph.empty() ? "" : " ") + line;
    lines.push_back(std::move(line));
  }
  end_paragraph();
  return out;
}

/// CLI11's formatter, whose help fits.
class FittedFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    const std::string help = CLI::Formatter::make_help(app, std::move(name), mode);
    return mode == CLI::AppFormatMode::Normal ? fitted(help, get_column_width() + 1) : help;
  }
};

}  // namespace collided
