#pragma once
// The tables that a scene has on the host. No gRPC here.

#include <algorithm>
#include <cstdint>

#include "gpu/detector.hpp"

namespace collided::server {

/// Copies of its topology: each part has its own.
inline uint64_t count_tables(const SceneSpec& spec) { return std::max<uint64_t>(spec.part_devices.size(), 1); }

}  // namespace collided::server
