#pragma once
// Items of many parts, on a GPU: the parts of some items are laid end to end and shared by the lanes of a warp, so that
// neither a lane nor its warp waits for the item with most.

#include <cstring>

#include "gpu/exec/counted.hpp"
#include "gpu/exec/step_clock.cuh"
#include "gpu/exec/warp.cuh"

namespace collided {

constexpr unsigned kPartsBlock = 128;

/// Items that a warp takes at once: fewer of those that may have many parts, for then one alone keeps it busy.
template <class Item>
constexpr unsigned kItemsOfWarp = Item::kMostParts <= 128 ? 8 : 4;

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

/// The parts of items [first, end), as many as a warp takes at once.
template <class F>
__device__ void do_parts(uint64_t first, uint64_t end, const F& f) {
  constexpr unsigned kItems = kItemsOfWarp<typename F::Item>;
  const uint64_t item = first + lane_id();
  typename F::Item mine{};
  if (lane_id() < kItems && item < end) mine = f.item(item);
  uint32_t up_to = mine.parts;
  for (unsigned offset = 1; offset < kItems; offset *= 2) {
    const uint32_t before = __shfl_up_sync(kAllLanes, up_to, offset);
    if (lane_id() >= offset) up_to += before;
  }
  const uint32_t all = __shfl_sync(kAllLanes, up_to, kItems - 1);
  constexpr int kAtOnce = 2;  // so that they wait for the memory together
  for (uint32_t first_part = 0; first_part < all; first_part += kAtOnce * 32) {
    typename F::Item owner[kAtOnce];
    uint32_t found[kAtOnce];
#pragma unroll
    for (int j = 0; j < kAtOnce; ++j) {
      const uint32_t part = first_part + static_cast<uint32_t>(j) * 32 + lane_id();
      const unsigned from = item_of_part<kItems>(part, up_to);
      owner[j] = shuffled(mine, from);
      const uint32_t start = __shfl_sync(kAllLanes, up_to - mine.parts, from);
      found[j] = part < all ? f.find(owner[j], part - start) : kNothing;
    }
#pragma unroll
    for (int j = 0; j < kAtOnce; ++j) {
      if (found[j] != kNothing) f.act(owner[j], found[j]);
      __syncwarp();
    }
  }
}

template <class F>
__global__ void __launch_bounds__(kPartsBlock) for_each_part_kernel(uint64_t* begin, Counted n, F f) {
  start_kernel(begin);
  const uint64_t size = n.size(), warp = (static_cast<uint64_t>(blockIdx.x) * kPartsBlock + threadIdx.x) / 32;
  constexpr unsigned kItems = kItemsOfWarp<typename F::Item>;
  const uint64_t stride = static_cast<uint64_t>(gridDim.x) * (kPartsBlock / 32) * kItems;
  for (uint64_t first = warp * kItems; first < size; first += stride) do_parts(first, size, f);
}

}  // namespace collided
