#pragma once
// Work that the lanes of a warp share among themselves.

#include "gpu/exec/cuda/warp.cuh"

namespace collided {

/// Takes `chunk` items for the warp; returns the first of them. `next`: the next item that no warp has taken yet.
__device__ inline uint64_t take_items(uint64_t* next, uint64_t chunk) {
  unsigned long long first = 0;
  if (lane_id() == 0) first = atomicAdd(reinterpret_cast<unsigned long long*>(next), chunk);
  return __shfl_sync(kAllLanes, first, 0);
}

/// Whether the frame has ended (CudaExec), so that what is left of it is in vain. Read before items are taken: the two
/// are then waited for at once.
__device__ inline bool is_stopped(const uint32_t* stop) { return *static_cast<const volatile uint32_t*>(stop) != 0; }

/// Items [first, end) that a warp holds.
template <class Number>
struct HeldItems {
  Number first = 0, end = 0;

  __device__ bool are_gone() const { return first == end; }
  /// Hands an item to each lane that wants one, as far as there are any; false: none. All lanes call.
  __device__ bool give(bool wants, Number& item) {
    const unsigned lanes = __ballot_sync(kAllLanes, wants);
    const Number mine = first + rank_among(lanes);
    const bool given = wants && mine < end;
    if (given) item = mine;
    first = min(end, static_cast<Number>(first + __popc(lanes)));
    return given;
  }
};

/// Items that a warp takes for its lanes.
class WarpItems {
 public:
  /// `next` as in take_items, `stop` as in is_stopped.
  __device__ WarpItems(uint64_t count, uint64_t* next, const uint32_t* stop) : count_(count), next_(next), stop_(stop) {
    const uint64_t warps = static_cast<uint64_t>(gridDim.x) * blockDim.x / 32;
    // Few items are spread thinly: lanes that go different ways wait for each other.
    chunk_ =
        count <= 32 * warps ? (count + warps - 1) / warps : min(uint64_t{256}, max(uint64_t{32}, count / (8 * warps)));
  }

  __device__ bool are_over() const { return over_; }

  /// As HeldItems::give, but false: none, for now.
  __device__ bool take(bool wants, uint64_t& item) {
    if (held_.are_gone() && !over_) fetch();
    return held_.give(wants, item);
  }

 private:
  __device__ void fetch() {
    const bool stopped = is_stopped(stop_);
    const uint64_t first = take_items(next_, chunk_);
    over_ = first >= count_ || __any_sync(kAllLanes, stopped);
    held_ = {over_ ? 0 : first, over_ ? 0 : min(count_, first + chunk_)};
  }

  const uint64_t count_;
  uint64_t* const next_;
  const uint32_t* const stop_;
  uint64_t chunk_;
  HeldItems<uint64_t> held_;
  bool over_ = false;
};

}  // namespace collided
