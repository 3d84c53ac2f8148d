#pragma once
// Items of some parts, on a GPU, so that no warp waits for the item with most: the parts of some items are laid end to
// end and shared by the lanes of a warp. Where F::kWalks, each lane first walks the parts of an item of its own, in
// step with the others, as long as most of them do: a step of a walk costs less than a part that is found by its place.

#include <cstring>

#include "gpu/exec/counted.hpp"
#include "gpu/exec/cuda/step_clock.cuh"
#include "gpu/exec/cuda/warp.cuh"

namespace collided {

constexpr unsigned kPartsBlock = 128;

/// Lanes that are enough to walk on: a part that is found by its place takes as long as several steps of a walk.
constexpr int kBusyLanes = 8;
/// Parts of a lane that are walked however few the lanes are: to share them out takes as long.
constexpr uint32_t kFewParts = 8;

/// Which item a part belongs to, of those whose parts end where `end` says, lane by lane.
template <unsigned items>
__device__ unsigned item_of_part(uint32_t part, uint32_t end) {
  unsigned item = 0;
  for (unsigned step = items / 2; step > 0; step /= 2)
    if (part >= __shfl_sync(kAllLanes, end, item + step - 1)) item += step;
  return item;
}

/// Another lane's value.
template <class T>
__device__ T shuffled(const T& value, unsigned lane) {
  static_assert(sizeof(T) % sizeof(uint32_t) == 0);
  constexpr int kWords = sizeof(T) / sizeof(uint32_t);
  uint32_t word[kWords];
  std::memcpy(word, &value, sizeof(T));
  for (int k = 0; k < kWords; ++k) word[k] = __shfl_sync(kAllLanes, word[k], lane);
  T out;
  std::memcpy(&out, word, sizeof(T));
  return out;
}

/// Whether the lanes, with `left` parts each, had better walk than share.
__device__ inline bool lanes_walk(uint32_t left) {
  const unsigned lanes = __ballot_sync(kAllLanes, left > 0);
  const bool any_has_many = __any_sync(kAllLanes, left > kFewParts);
  return __popc(lanes) >= kBusyLanes || (lanes != 0 && !any_has_many);
}

/// Each lane walks its item, as long as it is worth it; returns how many parts of each are done.
template <class F>
__device__ uint32_t walk_parts(const typename F::Item& mine, const F& f) {
  constexpr uint32_t kAtOnce = 4;  // so that they wait for the memory together
  auto walk = mine.walk();
  uint32_t done = 0;
  for (; lanes_walk(mine.parts - min(done, mine.parts)); done += kAtOnce) {
    uint32_t part[kAtOnce], seen[kAtOnce], found[kAtOnce];
#pragma unroll
    for (uint32_t j = 0; j < kAtOnce; ++j) part[j] = walk.next();
#pragma unroll
    for (uint32_t j = 0; j < kAtOnce; ++j) seen[j] = done + j < mine.parts ? f.look(part[j]) : 0;
#pragma unroll
    for (uint32_t j = 0; j < kAtOnce; ++j) found[j] = done + j < mine.parts ? f.find(part[j], seen[j]) : kNothing;
#pragma unroll
    for (uint32_t j = 0; j < kAtOnce; ++j) {
      if (found[j] != kNothing) f.act(mine, found[j]);
      __syncwarp();
    }
  }
  return done;
}

/// All parts of the items of the first lanes but the first `done` of each, laid end to end.
template <unsigned items, class F>
__device__ void share_parts(const typename F::Item& mine, uint32_t done, const F& f) {
  const uint32_t left = mine.parts - min(done, mine.parts);
  uint32_t up_to = left;
  for (unsigned offset = 1; offset < items; offset *= 2) {
    const uint32_t before = __shfl_up_sync(kAllLanes, up_to, offset);
    if (lane_id() >= offset) up_to += before;
  }
  const uint32_t all = __shfl_sync(kAllLanes, up_to, items - 1);
  constexpr int kAtOnce = 2;
  for (uint32_t first_part = 0; first_part < all; first_part += kAtOnce * 32) {
    typename F::Item owner[kAtOnce];
    uint32_t found[kAtOnce];
#pragma unroll
    for (int j = 0; j < kAtOnce; ++j) {
      const uint32_t part = first_part + static_cast<uint32_t>(j) * 32 + lane_id();
      const unsigned from = item_of_part<items>(part, up_to);
      owner[j] = shuffled(mine, from);
      const uint32_t start = __shfl_sync(kAllLanes, up_to - left, from);
      found[j] = part < all ? found_in(f, owner[j].part(done + part - start)) : kNothing;
    }
#pragma unroll
    for (int j = 0; j < kAtOnce; ++j) {
      if (found[j] != kNothing) f.act(owner[j], found[j]);
      __syncwarp();
    }
  }
}

/// Items that a warp walks at once, at least: where they are few, the processors are not full.
constexpr unsigned kFewestItems = 8;

/// Items that a warp takes at once, at least.
template <class F>
constexpr unsigned kLeastItems = F::kWalks ? kFewestItems : F::Item::kShared;

template <class F>
__device__ uint64_t items_of_warp(uint64_t size, uint64_t warps) {
  if (!F::kWalks) return kLeastItems<F>;
  return size >= 32 * warps ? 32 : max(uint64_t{kLeastItems<F>}, (size + warps - 1) / warps);
}

/// The parts of the lanes' items.
template <class F>
__device__ void do_parts(const typename F::Item& mine, const F& f) {
  if constexpr (F::kWalks) {
    const uint32_t done = walk_parts(mine, f);
    if (__any_sync(kAllLanes, mine.parts > done)) share_parts<32>(mine, done, f);
  } else {
    share_parts<F::Item::kShared>(mine, 0, f);
  }
}

template <class F>
__global__ void __launch_bounds__(kPartsBlock) for_each_part_kernel(uint64_t* begin, Counted n, F f) {
  note_begin(begin);
  const uint64_t size = n.size(), warp = (static_cast<uint64_t>(blockIdx.x) * kPartsBlock + threadIdx.x) / 32;
  const uint64_t warps = static_cast<uint64_t>(gridDim.x) * (kPartsBlock / 32);
  const uint64_t items = items_of_warp<F>(size, warps);
  for (uint64_t first = warp * items; first < size; first += warps * items) {
    const uint64_t item = first + lane_id();
    typename F::Item mine{};
    if (lane_id() < items && item < size) mine = f.item(item);
    __syncwarp();
    do_parts(mine, f);
  }
}

}  // namespace collided
