#pragma once
// The search for pairs by walks through a tree, on a GPU: a walk a lane. Neighbours in the order of the items walk
// nearly alike; a lane whose walk is over takes the warp's next item, and pairs go through the queues of
// pair_queues.cuh.

#include "gpu/exec/pair_queues.cuh"
#include "gpu/exec/step_clock.cuh"
#include "gpu/exec/warp_items.cuh"

namespace collided {

/// `next` is a zeroed counter.
template <class Source, class Sink>
__global__ void __launch_bounds__(kSearchBlock)
    tree_walk_kernel(uint64_t* begin, uint64_t count, uint64_t* next, Source source, Sink sink) {
  start_kernel(begin);
  // Lanes wait for the slowest of them after this many steps, to hand over what they found.
  constexpr int kSteps = 4;
  __shared__ PairQueuesShared shared[kSearchBlock / 32];
  PairQueues<Sink> pairs(sink, shared[threadIdx.x / 32]);
  WarpItems items(count, next);
  typename Source::Walk walk;
  uint64_t steps = 0;
  for (;;) {
    if (__any_sync(kAllLanes, walk.is_over()) && !items.are_over()) {
      uint64_t item = 0;
      if (items.take(walk.is_over(), sink.is_over(), item)) walk = source.walk(item);
    }
    if (items.are_over() && __all_sync(kAllLanes, walk.is_over())) break;
    bool found = false;
    for (int k = 0; k < kSteps && !found && !walk.is_over(); ++k, ++steps) found = source.step(walk);
    pairs.add(found, walk.triangle, walk.found);
  }
  pairs.finish();
  for (int offset = 16; offset > 0; offset /= 2) steps += __shfl_xor_sync(kAllLanes, steps, offset);
  if (lane_id() == 0) source.add_tests(steps);
}

}  // namespace collided
