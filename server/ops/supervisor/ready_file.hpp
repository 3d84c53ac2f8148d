#pragma once
// A file that tells scripts that the daemon serves, and where.

#include <string>
#include <vector>

namespace collided::server {

/// Why the file cannot be written; empty if it can, and for an empty path. What is there must be a regular file, for it
/// is replaced: a device, a pipe or a link would be lost.
std::string ready_file_obstacle(const std::string& path);

/// Writes the addresses, one per line; nothing to an empty path. Renamed into place, so that no reader sees a part of
/// it. Throws std::runtime_error.
void write_ready_file(const std::string& path, const std::vector<std::string>& addresses);

}  // namespace collided::server
