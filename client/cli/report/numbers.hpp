#pragma once
// Numbers as people read them.

#include <cstdint>
#include <string>

namespace collided::cli {

/// One double by a format of printf, such as "%g".
std::string format_double(const char* format, double x);
/// With commas between thousands.
std::string count_text(uint64_t n);
/// Three digits, more only before the point: "0.123", "12.3", "1,235".
std::string milliseconds_text(double ms);

}  // namespace collided::cli
