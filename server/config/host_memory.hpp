#pragma once
// The memory that this process may use.

#include <cstdint>
#include <string>

namespace collided::server {

/// Bytes: the least of what the host has (MemTotal), what the limits of the process's control group and of those around
/// it allow, and RLIMIT_AS. `root` is where proc and sys/fs/cgroup are, empty for the real ones; 0 if nothing tells.
uint64_t host_memory(const std::string& root = "");

}  // namespace collided::server
