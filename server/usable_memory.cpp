// The memory that scenes may have.
#include "server/usable_memory.hpp"

#include "server/config/host_limits.hpp"
#include "server/devices/chosen_devices.hpp"

namespace collided::server {

Memory usable_memory(const Config& config) {
  Memory memory{host_memory(), 0};
  if (config.backend == "cpu") return memory;
  for (const auto& info : chosen_devices(config))
    if (info.device.backend == Backend::kCuda) memory.device += info.memory_bytes;
  return memory;
}

}  // namespace collided::server
