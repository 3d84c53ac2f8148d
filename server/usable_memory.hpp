#pragma once
// The memory that scenes may have.

#include "server/config/config.hpp"
#include "server/config/memory_limits.hpp"

namespace collided::server {

/// Scenes live on the CUDA devices that are served, unless the backend is "cpu". Throws ConfigError for a device that
/// is not there.
Memory usable_memory(const Config& config);

}  // namespace collided::server
