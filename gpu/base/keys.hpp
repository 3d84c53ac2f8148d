#pragma once
// The key of a pair: both ids, the first in the upper half, so that keys sort as pairs do.

#include <cstdint>

#include "gpu/base/host_device.hpp"

namespace collided {

COLLIDED_HD inline uint64_t pack_ids(uint32_t first, uint32_t second) { return uint64_t{first} << 32 | second; }
COLLIDED_HD inline uint32_t first_id(uint64_t key) { return static_cast<uint32_t>(key >> 32); }
COLLIDED_HD inline uint32_t second_id(uint64_t key) { return static_cast<uint32_t>(key); }

}  // namespace collided
