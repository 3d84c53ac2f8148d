#pragma once
// Names of files of which there is one for each frame: "{frame}" stands for the frame's number.

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

}  // namespace collided::cli
