#pragma once
// The lanes of a warp.

#include <cuda_runtime.h>

#include <cstdint>

namespace collided {

constexpr unsigned kAllLanes = ~0u;

__device__ inline unsigned lane_id() { return threadIdx.x & 31u; }

}  // namespace collided
