#pragma once
// What the footer of --help holds.

#include <sstream>
#include <string>
#include <vector>

namespace collided::manual {

struct Footer {
  std::vector<std::string> paragraphs;
  std::string examples;    ///< indented lines
  std::string exit_codes;  ///< without the words "Exit codes: "
};

/// Paragraphs are lines without an empty one between them.
inline Footer footer_of(const std::string& text) {
  constexpr std::string_view kExitCodes = "Exit codes: ";
  Footer footer;
  std::istringstream lines(text);
  bool is_new = true;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("  ")) {
      footer.examples += line + "\n";
    } else if (line.starts_with(kExitCodes)) {
      footer.exit_codes = line.substr(kExitCodes.size());
    } else if (!line.empty() && is_new) {
      footer.paragraphs.push_back(line);
    } else if (!line.empty()) {
      footer.paragraphs.back() += " " + line;
    }
    is_new = line.empty() || line.starts_with("  ") || line.starts_with(kExitCodes);
  }
  return footer;
}

}  // namespace collided::manual
