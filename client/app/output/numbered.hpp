#pragma once
// Names of files of which there is one for each frame: "{frame}" stands for the frame's number.

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

namespace collided::cli {

constexpr std::string_view kFrameField = "{frame}";

inline bool is_numbered(const std::string& pattern) { return pattern.find(kFrameField) != std::string::npos; }

/// Each "{frame}" replaced by the number, in four digits or more, so that names sort as frames do.
inline std::string numbered(std::string pattern, uint64_t frame) {
  constexpr size_t kDigits = 4;
  std::string number = std::to_string(frame);
  if (number.size() < kDigits) number.insert(0, kDigits - number.size(), '0');
  for (size_t at = 0; (at = pattern.find(kFrameField, at)) != std::string::npos; at += number.size())
    pattern.replace(at, kFrameField.size(), number);
  return pattern;
}

/// Whether some frame's number makes `pattern` this name.
inline bool gives(const std::string& pattern, const std::string& name) {
  constexpr size_t kMaxDigits = 20;
  const size_t first = pattern.find(kFrameField);
  if (first == std::string::npos || name.compare(0, first, pattern, 0, first) != 0) return false;
  for (size_t digits = 1; digits <= kMaxDigits && first + digits <= name.size(); ++digits) {
    uint64_t frame = 0;
    const char *const begin = name.data() + first, *const end = begin + digits;
    if (std::from_chars(begin, end, frame).ptr == end && numbered(pattern, frame) == name) return true;
  }
  return false;
}

}  // namespace collided::cli
