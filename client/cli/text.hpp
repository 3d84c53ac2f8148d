#pragma once
// Numbers as people read them, and text files.

#include <cstdint>
#include <filesystem>
#include <string>

namespace collided::cli {

/// One double by a format of printf, such as "%g".
std::string format_double(const char* format, double x);
/// With commas between thousands.
std::string count_text(uint64_t n);
/// Three digits, more only before the point: "0.123", "12.3", "1,235".
std::string milliseconds_text(double ms);

/// Throws std::runtime_error if the file cannot be written.
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace collided::cli
