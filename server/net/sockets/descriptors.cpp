// How many file descriptors the process may have.
#include "server/net/sockets/descriptors.hpp"

#include <sys/resource.h>

#include <algorithm>

namespace collided::server {

DescriptorLimit raise_descriptor_limit() {
  const size_t before = descriptor_limit();
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur < limit.rlim_max) {
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_NOFILE, &limit);
  }
  return {before, descriptor_limit()};
}

size_t descriptor_limit() {
  rlimit limit{};
  return getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur : 0;
}

size_t connections_for(size_t descriptors, size_t wanted) {
  constexpr size_t kDefaultMax = 1024, kMin = 8;
  const size_t max = std::max(kMin, descriptors - descriptors / 4);
  return wanted ? std::min(wanted, max) : std::max(kMin, std::min(kDefaultMax, descriptors / 2));
}

}  // namespace collided::server
