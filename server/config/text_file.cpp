// Small files that options name, as text, and as TOML that is safe to parse.
#include "server/config/text_file.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "server/config/config.hpp"

namespace collided::server {
namespace {

// Position after the string that begins with the quotation mark at `begin`. An unterminated string extends to the end
// of its line, or, if it may span lines, of the text.
size_t after_string(std::string_view text, size_t begin) {
  const char mark = text[begin];
  const std::string three(3, mark);
  const bool is_long = text.substr(begin, 3) == three;
  const std::string_view end = is_long ? std::string_view(three) : text.substr(begin, 1);
  size_t at = begin + end.size();
  while (at < text.size() && text.substr(at, end.size()) != end) {
    if (text[at] == '\n' && !is_long) return at;
    at += mark == '"' && text[at] == '\\' ? 2 : 1;
  }
  return std::min(text.size(), at + end.size());
}

// Depth of nesting, outside strings and comments.
class Depth {
 public:
  bool is_too_deep() const { return brackets_ > kMaxTomlNesting || parts_ > kMaxTomlNesting; }
  void take(char c) {
    if (c == '[' || c == '{') ++brackets_;
    if ((c == ']' || c == '}') && brackets_ > 0) --brackets_;
    if (c == '.') ++parts_;
    if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) parts_ = 1;
  }

 private:
  int brackets_ = 0, parts_ = 1;
};

}  // namespace

std::string read_text_file(const std::string& path, uint64_t max_bytes) {
  std::error_code error;
  // Devices and pipes could be endless, or block.
  if (!std::filesystem::is_regular_file(path, error)) throw ConfigError(path + ": is not a readable file");
  std::ifstream file(path, std::ios::binary);
  std::string text(max_bytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file && !file.eof()) throw ConfigError(path + ": cannot be read");
  text.resize(static_cast<size_t>(file.gcount()));
  if (text.size() > max_bytes) throw ConfigError(path + ": has more than " + std::to_string(max_bytes) + " bytes");
  return text;
}

int too_deep_line(std::string_view text) {
  Depth depth;
  for (size_t at = 0; at < text.size();) {
    if (text[at] == '"' || text[at] == '\'') {
      at = after_string(text, at);
    } else if (text[at] == '#') {
      at = std::min(text.size(), text.find('\n', at));
    } else {
      depth.take(text[at++]);
    }
    if (depth.is_too_deep()) return 1 + static_cast<int>(std::ranges::count(text.substr(0, at), '\n'));
  }
  return 0;
}

std::string read_toml_text(const std::string& path, uint64_t max_bytes) {
  auto text = read_text_file(path, max_bytes);
  if (const int line = too_deep_line(text))
    throw ConfigError(path + ":" + std::to_string(line) + ": nests deeper than " + std::to_string(kMaxTomlNesting) +
                      " levels");
  return text;
}

}  // namespace collided::server
