#pragma once
// The memory that scenes may have.

#include "server/config/config.hpp"
#include "server/config/memory_limits.hpp"

namespace collided::server {

/// Scenes live on a CUDA device where there is one, unless the backend is "cpu".
Memory usable_memory(const Config& config);

}  // namespace collided::server
