#pragma once
// The search for pairs by walks through a tree, on a GPU: a walk a lane. Neighbours in the order of the items walk
// nearly alike; a lane whose walk is over takes the warp's next item, and pairs go through the queues of
// pair_queues.cuh.

#include "gpu/exec/pair_queues.cuh"

namespace collided {

/// Items that a warp has taken for its lanes.
class WarpItems {
 public:
  __device__ WarpItems(uint64_t count, uint64_t* next, uint64_t chunk) : count_(count), next_(next), chunk_(chunk) {}

  __device__ bool are_over() const { return over_; }

  /// Hands an item to each lane that wants one, as far as there are any; false: none, for now. All lanes call.
  template <class Sink>
  __device__ bool take(bool wants, const Sink& sink, uint64_t& item) {
    if (first_ == end_ && !over_) fetch(sink);
    const unsigned lanes = __ballot_sync(kAllLanes, wants);
    const uint64_t mine = first_ + __popc(lanes & ((1u << lane_id()) - 1u));
    const bool given = wants && mine < end_;
    if (given) item = mine;
    first_ = min(end_, first_ + __popc(lanes));
    return given;
  }

 private:
  template <class Sink>
  __device__ void fetch(const Sink& sink) {
    uint64_t first = 0;
    if (lane_id() == 0)
      first = atomicAdd(reinterpret_cast<unsigned long long*>(next_), static_cast<unsigned long long>(chunk_));
    first = __shfl_sync(kAllLanes, first, 0);
    over_ = first >= count_ || __any_sync(kAllLanes, sink.is_over());
    first_ = over_ ? 0 : first;
    end_ = over_ ? 0 : min(count_, first + chunk_);
  }

  const uint64_t count_;
  uint64_t* const next_;  ///< the next item that no warp has taken yet
  const uint64_t chunk_;
  uint64_t first_ = 0, end_ = 0;
  bool over_ = false;
};

/// `next` is a zeroed counter.
template <class Source, class Sink>
__global__ void __launch_bounds__(kSearchBlock)
    tree_walk_kernel(uint64_t count, uint64_t* next, Source source, Sink sink) {
  // Lanes wait for the slowest of them after this many steps, to hand over what they found.
  constexpr int kSteps = 4;
  __shared__ PairQueuesShared shared[kSearchBlock / 32];
  PairQueues<Sink> pairs(sink, shared[threadIdx.x / 32]);
  const uint64_t warps = static_cast<uint64_t>(gridDim.x) * (kSearchBlock / 32);
  WarpItems items(count, next, min(uint64_t{256}, max(uint64_t{32}, count / (8 * warps))));
  typename Source::Walk walk;
  uint64_t steps = 0;
  for (;;) {
    if (__any_sync(kAllLanes, walk.is_over()) && !items.are_over()) {
      uint64_t item = 0;
      if (items.take(walk.is_over(), sink, item)) walk = source.walk(item);
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
