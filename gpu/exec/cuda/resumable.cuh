#pragma once
// Items that take different numbers of steps, on a GPU: an item a lane. Lanes that are done wait until there are enough
// of them to finish and to begin others together, for what one lane does all wait for.

#include "gpu/exec/counted.hpp"
#include "gpu/exec/cuda/step_clock.cuh"
#include "gpu/exec/cuda/warp_items.cuh"

namespace collided {

constexpr unsigned kResumableBlock = 128;

/// `next` is a zeroed counter.
template <class F>
__global__ void __launch_bounds__(kResumableBlock)
    for_each_resumable_kernel(uint64_t* begin, Counted n, uint64_t* next, const uint32_t* stop, F f) {
  note_begin(begin);
  constexpr int kEnough = 12;  // lanes
  WarpItems items(n.size(), next, stop);
  typename F::State state;
  bool unfinished = false;
  for (;;) {
    const int waiting = __popc(__ballot_sync(kAllLanes, state.is_over()));
    if (waiting == 32 || (waiting >= kEnough && !items.are_over())) {
      if (unfinished && state.is_over()) f.finish(state);
      unfinished = unfinished && !state.is_over();
      __syncwarp();
      if (waiting == 32 && items.are_over()) break;
      uint64_t item = 0;
      if (items.take(state.is_over(), item)) {
        f.begin(item, state);
        unfinished = !state.is_over();
      }
      __syncwarp();
    }
    if (!state.is_over()) f.step(state);
    __syncwarp();
  }
}

}  // namespace collided
