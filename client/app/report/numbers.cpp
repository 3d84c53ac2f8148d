// Numbers for people.

#include "client/app/report/numbers.hpp"

#include <cstdio>
#include <iterator>

namespace collided::cli {

std::string format_double(const char* format, double x) {
  char text[48];
  std::snprintf(text, sizeof text, format, x);
  return text;
}

std::string count_text(uint64_t n) {
  std::string text = std::to_string(n);
  for (size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, ",");
  return text;
}

std::string milliseconds_text(double ms) {
  return ms >= 1000 ? count_text(static_cast<uint64_t>(ms + 0.5)) : format_double(ms >= 100 ? "%.0f" : "%.3g", ms);
}

std::string bytes_text(double bytes) {
  static constexpr const char* kUnits[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  size_t unit = 0;
  for (; bytes >= 1024 && unit + 1 < std::size(kUnits); ++unit) bytes /= 1024;
  return format_double(bytes >= 100 || unit == 0 ? "%.0f " : "%.3g ", bytes) + kUnits[unit];
}

}  // namespace collided::cli
