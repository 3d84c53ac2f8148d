#pragma once
// The memory and processes that this process may have.

#include <cstdint>
#include <limits>
#include <string>

namespace collided::server {

constexpr uint64_t kNoLimit = std::numeric_limits<uint64_t>::max();

/// A limit's controller, and its files in both versions of cgroups.
struct CgroupLimit {
  const char* controller;
  const char* v2_file;
  const char* v1_file;
};
constexpr CgroupLimit kCgroupMemory{"memory", "memory.max", "memory.limit_in_bytes"};
constexpr CgroupLimit kCgroupProcesses{"pids", "pids.max", "pids.max"};

/// Returns the minimum over the process's cgroup and its parents; kNoLimit if none has one. `root` is the parent of
/// proc and sys/fs/cgroup, empty for the real ones.
uint64_t cgroup_limit(const CgroupLimit& limit, const std::string& root = "");

/// Returns a limit of the process, such as RLIMIT_AS; kNoLimit if there is none.
uint64_t soft_limit(int resource);

/// Bytes: the minimum of MemTotal, the limits of the process's cgroup and its parents, and RLIMIT_AS; 0 if none is
/// known. `root` is the parent of proc and sys/fs/cgroup, empty for the real ones.
uint64_t host_memory(const std::string& root = "");

/// False under strict overcommit (vm.overcommit_memory is 2). A client can release pages of the memory that it shares,
/// which the system allocates again when they are touched. It may then have none left, and would kill the daemon with
/// SIGBUS.
bool overcommits_memory();

}  // namespace collided::server
