#pragma once
// On a GPU: the boxes of neighbours, as they are in this step, a lane each; what passes goes through the warp's queues.

#include "gpu/exec/cuda/step_clock.cuh"
#include "gpu/exec/cuda/warp_items.cuh"
#include "gpu/search/cuda/pair_queues.cuh"

namespace collided {

/// Those of one kind that are this warp's, as many steps apart as there are warps.
template <class Sink, class Test>
__device__ void test_neighbours(const Span<const uint64_t>& all, uint64_t count, const uint32_t* stop,
                                const PairQueues<Sink>& pairs, const Sink& sink, const Test& test) {
  const uint64_t warps = static_cast<uint64_t>(gridDim.x) * (blockDim.x / 32);
  const uint64_t warp = (static_cast<uint64_t>(blockIdx.x) * blockDim.x + threadIdx.x) / 32;
  for (uint64_t first = 32 * warp; first < count; first += 32 * warps) {
    const bool over = pairs.is_overfull() | sink.early_exit.is_over() | is_stopped(stop);
    const uint64_t mine = first + lane_id();
    const bool active = mine < count;
    const uint64_t packed = active ? all[mine] : 0;
    if (__any_sync(kAllLanes, over)) return;
    test(active, packed);
  }
}

template <class Sink>
__global__ void __launch_bounds__(kSearchBlock)
    neighbour_test_kernel(uint64_t* begin, Neighbours neighbours, const uint32_t* stop, Sink sink) {
  note_begin(begin);
  __shared__ PairQueuesShared shared[kSearchBlock / 32];
  PairQueues<Sink> pairs(sink, shared[threadIdx.x / 32]);
  test_neighbours(neighbours.first, neighbours.size(0), stop, pairs, sink,
                  [&](bool active, uint64_t packed) { pairs.test_first(active, packed); });
  test_neighbours(neighbours.second, neighbours.size(1), stop, pairs, sink,
                  [&](bool active, uint64_t packed) { pairs.test_second(active, packed); });
  pairs.finish();
}

}  // namespace collided
