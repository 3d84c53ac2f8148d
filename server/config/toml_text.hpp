#pragma once
// The text of a TOML file, as far as it is safe to parse.

#include <cstdint>
#include <string>
#include <string_view>

namespace collided::server {

/// Brackets within each other, and parts of a dotted key. The parser calls itself for each of them.
constexpr int kMaxTomlNesting = 16;

/// The line in which the text nests deeper than kMaxTomlNesting; 0 if it does not.
int too_deep_line(std::string_view text);

/// The whole file. Throws ConfigError that names path and line if it nests too deep, and what read_text_file() throws.
std::string read_toml_text(const std::string& path, uint64_t max_bytes);

}  // namespace collided::server
