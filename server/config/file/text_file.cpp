// Small files that options name, as text, and as TOML that is safe to parse.
#include "server/config/file/text_file.hpp"

#include <algorithm>
#include <bit>
#include <filesystem>
#include <fstream>

#include "server/config/file/config_error.hpp"

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

constexpr std::string_view kSeparators = "=,[]{}\n";  // of keys and values

// Depth of nesting, outside strings and comments.
class Depth {
 public:
  bool is_too_deep() const { return brackets_ > kMaxTomlNesting || parts_ > kMaxTomlNesting; }
  void take(char c) {
    if (c == '[' || c == '{') ++brackets_;
    if ((c == ']' || c == '}') && brackets_ > 0) --brackets_;
    if (c == '.') ++parts_;
    if (kSeparators.find(c) != std::string_view::npos) parts_ = 1;
  }

 private:
  int brackets_ = 0, parts_ = 1;
};

// Dotted keys and headers, and whether there is an empty array, outside strings and comments.
class DottedKeys {
 public:
  bool has_empty_array() const { return has_empty_array_; }
  /// Whether such a key or header ends with this character.
  bool take(char c) {
    if (c == ' ' || c == '\t') return false;
    if (c == '[' && begins_line_ && brackets_ == 0) is_header_ = true;
    if (c == ']' && last_ == '[') has_empty_array_ = true;
    const bool is_dotted = has_dot_ && (c == '=' || (c == ']' && is_header_));
    count(c);
    return is_dotted;
  }

 private:
  void count(char c) {
    if (c == '.') has_dot_ = true;
    if (kSeparators.find(c) != std::string_view::npos) has_dot_ = false;
    if (c == '[' || c == '{') ++brackets_;
    if ((c == ']' || c == '}') && brackets_ > 0) --brackets_;
    begins_line_ = c == '\n';
    if (begins_line_)
      is_header_ = false;
    else if (c != '\r')
      last_ = c;
  }

  int brackets_ = 0;
  bool begins_line_ = true, is_header_ = false, has_dot_ = false, has_empty_array_ = false;
  char last_ = 0;  // but for white space
};

// Gives each character outside strings and comments, of a string its first, to `visit` until that returns true. Returns
// the position of that character, or npos.
template <class Visit>
size_t find_outside(std::string_view text, Visit visit) {
  for (size_t at = 0; at < text.size();) {
    if (text[at] == '#') {
      at = std::min(text.size(), text.find('\n', at));
      continue;
    }
    if (visit(text[at])) return at;
    at = text[at] == '"' || text[at] == '\'' ? after_string(text, at) : at + 1;
  }
  return std::string_view::npos;
}

// Bytes of the UTF-8 character that `text` begins with; 0 if there is none.
size_t character_bytes(std::string_view text) {
  constexpr uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};  // of so many bytes
  const auto bytes = static_cast<size_t>(std::countl_one(static_cast<uint8_t>(text[0])));
  if (bytes == 0) return 1;
  if (bytes == 1 || bytes > 4 || bytes > text.size()) return 0;
  uint32_t character = static_cast<uint8_t>(text[0]) & (0x7fu >> bytes);
  for (const char c : text.substr(1, bytes - 1)) {
    if ((c & 0xc0) != 0x80) return 0;
    character = character << 6 | (c & 0x3f);
  }
  const bool is_surrogate = character >= 0xd800 && character <= 0xdfff;
  return character >= kLeast[bytes] && character <= 0x10ffff && !is_surrogate ? bytes : 0;
}

int line_at(std::string_view text, size_t at) {
  return 1 + static_cast<int>(std::ranges::count(text.substr(0, at), '\n'));
}

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
  const size_t at = find_outside(text, [&](char c) {
    depth.take(c);
    return depth.is_too_deep();
  });
  return at == std::string_view::npos ? 0 : line_at(text, at);
}

int dotted_line(std::string_view text) {
  DottedKeys keys;
  find_outside(text, [&](char c) {
    keys.take(c);
    return keys.has_empty_array();
  });
  if (!keys.has_empty_array()) return 0;
  const size_t at = find_outside(text, [keys = DottedKeys()](char c) mutable { return keys.take(c); });
  return at == std::string_view::npos ? 0 : line_at(text, at);
}

int not_utf8_line(std::string_view text) {
  for (size_t at = 0, bytes = 0; at < text.size(); at += bytes)
    if ((bytes = character_bytes(text.substr(at))) == 0) return line_at(text, at);
  return 0;
}

std::string read_toml_text(const std::string& path, uint64_t max_bytes) {
  auto text = read_text_file(path, max_bytes);
  if (const int line = not_utf8_line(text))
    throw ConfigError(path + ":" + std::to_string(line) + ": is not UTF-8, as TOML must be");
  if (const int line = too_deep_line(text))
    throw ConfigError(path + ":" + std::to_string(line) + ": nests deeper than " + std::to_string(kMaxTomlNesting) +
                      " levels");
  if (const int line = dotted_line(text))
    throw ConfigError(path + ":" + std::to_string(line) +
                      ": has a key or header with a dot, in a file with an empty array");
  return text;
}

}  // namespace collided::server
