#pragma once
// The lanes of a warp.

#include <cuda_runtime.h>

#include <cstdint>

namespace collided {

constexpr unsigned kAllLanes = ~0u;

__device__ inline unsigned lane_id() { return threadIdx.x & 31u; }
/// How many of the lanes come before this one.
__device__ inline unsigned rank_among(unsigned lanes) { return __popc(lanes & ((1u << lane_id()) - 1u)); }

}  // namespace collided
