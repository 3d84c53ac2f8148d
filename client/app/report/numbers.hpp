#pragma once
// Numbers for people.

#include <cstdint>
#include <string>

namespace collided::cli {

/// A double in a printf format such as "%g".
std::string format_double(const char* format, double x);
/// With commas between thousands.
std::string count_text(uint64_t n);
/// Three significant digits, or all digits before the point: "0.123", "12.3", "1,235".
std::string milliseconds_text(double ms);

/// In the largest unit that leaves a digit before the point: "512 B", "1.5 KiB", "2.25 GiB".
std::string bytes_text(double bytes);

}  // namespace collided::cli
