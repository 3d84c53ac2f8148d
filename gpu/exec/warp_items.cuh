#pragma once
// Work that the lanes of a warp share among themselves.

#include "gpu/exec/warp.cuh"

namespace collided {

/// Takes `chunk` items for the warp; returns the first of them. `next`: the next item that no warp has taken yet.
__device__ inline uint64_t take_items(uint64_t* next, uint64_t chunk) {
  unsigned long long first = 0;
  if (lane_id() == 0) first = atomicAdd(reinterpret_cast<unsigned long long*>(next), chunk);
  return __shfl_sync(kAllLanes, first, 0);
}

/// Items that a warp has taken for its lanes.
class WarpItems {
 public:
  /// `next` as in take_items.
  __device__ WarpItems(uint64_t count, uint64_t* next) : count_(count), next_(next) {
    const uint64_t warps = static_cast<uint64_t>(gridDim.x) * blockDim.x / 32;
    // Few items are spread thinly: lanes that go different ways wait for each other.
    chunk_ =
        count <= 32 * warps ? (count + warps - 1) / warps : min(uint64_t{256}, max(uint64_t{32}, count / (8 * warps)));
  }

  __device__ bool are_over() const { return over_; }

  /// Hands an item to each lane that wants one, as far as there are any; false: none, for now. All lanes call.
  /// `stop`: no more, whatever there is.
  __device__ bool take(bool wants, bool stop, uint64_t& item) {
    if (first_ == end_ && !over_) fetch(stop);
    const unsigned lanes = __ballot_sync(kAllLanes, wants);
    const uint64_t mine = first_ + rank_among(lanes);
    const bool given = wants && mine < end_;
    if (given) item = mine;
    first_ = min(end_, first_ + __popc(lanes));
    return given;
  }

 private:
  __device__ void fetch(bool stop) {
    const uint64_t first = take_items(next_, chunk_);
    over_ = first >= count_ || __any_sync(kAllLanes, stop);
    first_ = over_ ? 0 : first;
    end_ = over_ ? 0 : min(count_, first + chunk_);
  }

  const uint64_t count_;
  uint64_t* const next_;
  uint64_t chunk_;
  uint64_t first_ = 0, end_ = 0;
  bool over_ = false;
};

}  // namespace collided
