#pragma once
// Small files that options name, as text, and as TOML that is safe to parse.

#include <cstdint>
#include <string>
#include <string_view>

namespace collided::server {

/// The whole file. Throws ConfigError that names the path if it cannot be read or has more than `max_bytes`.
std::string read_text_file(const std::string& path, uint64_t max_bytes);

/// Maximum depth of brackets, and maximum number of parts of a dotted key: the parser recurses for each.
constexpr int kMaxTomlNesting = 16;

/// The line in which the text nests deeper than kMaxTomlNesting; 0 if it does not.
int too_deep_line(std::string_view text);

/// The first line with bytes that are not UTF-8, beyond which the parser would read memory that is not the text's; 0 if
/// there is none.
int not_utf8_line(std::string_view text);

/// The first line with a dotted key or header, in a text that has an empty array; 0 if there is none. One that goes
/// through such an array (`a = []`, then `a.b = 1`) would end the process: the parser takes the array's last element.
int dotted_line(std::string_view text);

/// As read_text_file(). Throws ConfigError that names path and line, too, if the text is not UTF-8, nests too deeply,
/// or has both empty arrays and dotted keys.
std::string read_toml_text(const std::string& path, uint64_t max_bytes);

}  // namespace collided::server
