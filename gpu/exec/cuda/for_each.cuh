#pragma once
// Items one by one, by a thread or by a group of threads each, on a GPU.

#include "gpu/exec/counted.hpp"
#include "gpu/exec/cuda/step_clock.cuh"

namespace collided {

constexpr unsigned kCountedBlock = 128;

template <class F>
__global__ void for_each_kernel(uint64_t* begin, uint64_t n, F f) {
  note_begin(begin);
  const uint64_t stride = static_cast<uint64_t>(gridDim.x) * blockDim.x;
  for (uint64_t i = static_cast<uint64_t>(blockIdx.x) * blockDim.x + threadIdx.x; i < n; i += stride) f(i);
}

template <class F>
__global__ void __launch_bounds__(kCountedBlock) for_each_counted_kernel(uint64_t* begin, Counted n, F f) {
  note_begin(begin);
  const uint64_t size = n.size(), stride = static_cast<uint64_t>(gridDim.x) * blockDim.x;
  for (uint64_t i = static_cast<uint64_t>(blockIdx.x) * blockDim.x + threadIdx.x; i < size; i += stride) f(i);
}

template <class F>
__global__ void __launch_bounds__(F::kGroupSize) for_each_group_kernel(uint64_t* begin, Counted n, F f) {
  note_begin(begin);
  __shared__ typename F::Shared shared;
  const uint64_t size = n.size();
  for (uint64_t i = blockIdx.x; i < size; i += gridDim.x) {
    f(i, Group{threadIdx.x, blockDim.x}, shared);
    __syncthreads();
  }
}

}  // namespace collided
