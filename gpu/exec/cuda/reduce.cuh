#pragma once
// A reduction in one launch: the block that ends last joins what the others found.

#include <cub/block/block_reduce.cuh>

#include "gpu/exec/cuda/step_clock.cuh"

namespace collided {

constexpr unsigned kReduceBlock = 128;

/// What blocks leave for the last one. `arrived` is 0 between launches.
template <class T>
struct Partial {
  T* of_block;
  unsigned* arrived;
};

template <class T, class F, class Op, class Then>
__global__ void __launch_bounds__(kReduceBlock) reduce_kernel(uint64_t* begin, uint64_t n, F transform, T identity,
                                                              Op op, Partial<T> partial, T* result, Then then) {
  note_begin(begin);
  using BlockReduce = cub::BlockReduce<T, kReduceBlock>;
  __shared__ typename BlockReduce::TempStorage memory;
  __shared__ bool is_last;
  T value = identity;
  const uint64_t stride = static_cast<uint64_t>(gridDim.x) * kReduceBlock;
  for (uint64_t i = static_cast<uint64_t>(blockIdx.x) * kReduceBlock + threadIdx.x; i < n; i += stride)
    value = op(value, transform(i));
  value = BlockReduce(memory).Reduce(value, op);
  if (threadIdx.x == 0) {
    partial.of_block[blockIdx.x] = value;
    __threadfence();
    is_last = atomicAdd(partial.arrived, 1u) == gridDim.x - 1;
  }
  __syncthreads();
  if (!is_last) return;
  __threadfence();
  value = identity;
  for (unsigned k = threadIdx.x; k < gridDim.x; k += kReduceBlock) value = op(value, partial.of_block[k]);
  value = BlockReduce(memory).Reduce(value, op);
  if (threadIdx.x != 0) return;
  *result = value;
  *partial.arrived = 0;
  then(0);
}

}  // namespace collided
