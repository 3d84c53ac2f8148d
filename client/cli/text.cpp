// Numbers as people read them, and text files.

#include "client/cli/text.hpp"

#include <cstdio>
#include <fstream>
#include <stdexcept>

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

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

}  // namespace collided::cli
