#pragma once
// Small files that options name.

#include <cstdint>
#include <string>

namespace collided::server {

/// The whole file. Throws ConfigError that names the path if it cannot be read or has more than `max_bytes`.
std::string read_text_file(const std::string& path, uint64_t max_bytes);

}  // namespace collided::server
