// The memory and processes that this process may have.
#include "server/config/host_limits.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>

namespace collided::server {
namespace {

uint64_t memory_total(const std::string& path) {
  std::ifstream file(path);
  for (std::string name; file >> name;)
    if (uint64_t kilobytes = 0; name == "MemTotal:" && file >> kilobytes) return kilobytes << 10;
  return kNoLimit;
}

// "max", or a missing file, means no limit.
uint64_t number_in(const std::string& path) {
  std::ifstream file(path);
  std::string text;
  uint64_t number = 0;
  file >> text;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? number : kNoLimit;
}

// The minimum over the cgroup at `path` below `mount` and its parents. In a container the path may not exist: then the
// container's own cgroup is mounted at `mount`.
uint64_t min_along(const std::string& mount, std::string path, const std::string& file) {
  uint64_t min = number_in(mount + "/" + file);
  for (; path.size() > 1; path.resize(path.rfind('/'))) min = std::min(min, number_in(mount + path + "/" + file));
  return min;
}

bool has_controller(const std::string& controllers, const std::string& name) {
  return ("," + controllers + ",").find("," + name + ",") != std::string::npos;
}

}  // namespace

uint64_t soft_limit(int resource) {
  rlimit limit{};
  const auto which = static_cast<__rlimit_resource>(resource);
  return getrlimit(which, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY ? limit.rlim_cur : kNoLimit;
}

// Lines of /proc/self/cgroup: 0::/path (cgroup v2), 4:memory:/path (v1).
uint64_t cgroup_limit(const CgroupLimit& limit, const std::string& root) {
  const std::string mount = root + "/sys/fs/cgroup";
  std::ifstream file(root + "/proc/self/cgroup");
  uint64_t min = kNoLimit;
  for (std::string line; std::getline(file, line);) {
    std::istringstream parts(line);
    std::string id, controllers, path;
    std::getline(std::getline(std::getline(parts, id, ':'), controllers, ':'), path);
    if (!path.starts_with('/')) continue;
    if (controllers.empty()) min = std::min(min, min_along(mount, path, limit.v2_file));
    if (has_controller(controllers, limit.controller))
      min = std::min(min, min_along(mount + "/" + limit.controller, path, limit.v1_file));
  }
  return min;
}

uint64_t host_memory(const std::string& root) {
  const uint64_t min = std::min({memory_total(root + "/proc/meminfo"), cgroup_limit(kCgroupMemory, root),
                                 root.empty() ? soft_limit(RLIMIT_AS) : kNoLimit});
  return min == kNoLimit ? 0 : min;
}

bool overcommits_memory() {
  constexpr int kStrict = 2;
  int policy = 0;
  std::ifstream("/proc/sys/vm/overcommit_memory") >> policy;
  return policy != kStrict;
}

}  // namespace collided::server
