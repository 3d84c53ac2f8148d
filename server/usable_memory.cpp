// The memory that scenes may have.
#include "server/usable_memory.hpp"

#include "gpu/detector.hpp"
#include "server/config/host_memory.hpp"

namespace collided::server {

Memory usable_memory(const Config& config) {
  Memory memory{host_memory(), 0};
  if (config.backend == "cpu") return memory;
  for (const auto& device : list_devices())
    if (device.device.backend == Backend::kCuda && (memory.device == 0 || device.memory_bytes < memory.device))
      memory.device = device.memory_bytes;
  return memory;
}

}  // namespace collided::server
