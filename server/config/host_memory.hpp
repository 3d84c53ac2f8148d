#pragma once
// The memory that this process may use.

#include <cstdint>
#include <string>

namespace collided::server {

/// Bytes: the minimum of MemTotal, the limits of the process's cgroup and its parents, and RLIMIT_AS; 0 if none is
/// known. `root` is the parent of proc and sys/fs/cgroup, empty for the real ones.
uint64_t host_memory(const std::string& root = "");

}  // namespace collided::server
