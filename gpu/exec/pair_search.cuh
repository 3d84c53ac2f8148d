#pragma once
// The search for pairs on a GPU. A warp takes an item: each lane holds a row's box, the columns' boxes pass by in
// shared memory. Pairs, and then the candidates that come of them, are gathered in shared memory until there are
// enough for all lanes, so that every step works with full warps and a list is appended to by a warp at a time.

#include <cuda_runtime.h>

#include "gpu/exec/counted.hpp"
#include "gpu/math/box.hpp"
#include "gpu/math/tiles.hpp"

namespace collided {

constexpr unsigned kAllLanes = ~0u;

/// Entries that wait for a full warp; a push adds at most 32, and 32 or more are taken out before the next.
struct WarpQueue {
  uint64_t entry[64];
};

__device__ inline unsigned lane_id() { return threadIdx.x & 31u; }

/// Appends the values of the lanes with `has`.
__device__ inline void push(WarpQueue& queue, unsigned& size, bool has, uint64_t value) {
  const unsigned lanes = __ballot_sync(kAllLanes, has);
  if (has) queue.entry[size + __popc(lanes & ((1u << lane_id()) - 1u))] = value;
  size += __popc(lanes);
  __syncwarp();
}

struct SearchShared {
  struct alignas(16) Member {
    float lo_x, lo_y, lo_z, hi_x, hi_y, hi_z;
    uint32_t id, unused;
  };
  Member column[kTile];
  WarpQueue pairs, first, second;
};

template <class Source, class Sink>
class WarpSearch {
 public:
  __device__ WarpSearch(const Source& source, const Sink& sink, SearchShared& shared)
      : source_(source), sink_(sink), shared_(shared) {}

  __device__ void search(uint64_t item) {
    const auto work = source_.work(item);
    const uint32_t mine = work.row + lane_id();
    const bool has_row = mine < work.leaf.count;
    const uint32_t a = has_row ? work.members[mine] : 0;
    const Box<float> box = source_.boxes[a];
    for (uint32_t first = work.first_column; first < work.end_column; first += kTile) {
      const uint32_t columns = load_columns(work, first);
      uint32_t hits = 0;
      for (uint32_t k = 0; k < columns; ++k) hits |= (overlaps(box, shared_.column[k]) ? 1u : 0u) << k;
      if (first == work.row) hits &= ~0u << lane_id() << 1;  // a tile with itself: only those after this one
      report(work, box, a, has_row ? hits : 0);
      __syncwarp();
    }
  }

  /// The pairs of the lanes with `found`; all lanes call.
  __device__ void add(bool found, uint32_t a, uint32_t b) {
    push(shared_.pairs, pairs_, found, uint64_t{min(a, b)} << 30 | max(a, b));
    if (pairs_ >= 32) drain_pairs(32);
  }

  /// After the last item.
  __device__ void finish() {
    if constexpr (Sink::kTakesPairs) {
      if (pairs_ > 0) drain_pairs(pairs_);
    } else {
      if (pairs_ > 0) drain_pairs(pairs_);
      if (first_ > 0) drain_first(first_);
      if (second_ > 0) drain_second(second_);
    }
    if (lane_id() == 0) sink_.add(pair_count_, first_count_, second_count_);
  }

 private:
  __device__ static bool overlaps(const Box<float>& a, const SearchShared::Member& b) {
    return a.lo.x <= b.hi_x && b.lo_x <= a.hi.x && a.lo.y <= b.hi_y && b.lo_y <= a.hi.y && a.lo.z <= b.hi_z &&
           b.lo_z <= a.hi.z;
  }

  template <class Work>
  __device__ uint32_t load_columns(const Work& work, uint32_t first) {
    const uint32_t columns = min(kTile, work.end_column - first);
    if (lane_id() < columns) {
      const uint32_t id = work.members[first + lane_id()];
      const Box<float> box = source_.boxes[id];
      shared_.column[lane_id()] = {box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z, id, 0};
    }
    __syncwarp();
    return columns;
  }

  template <class Work>
  __device__ void report(const Work& work, const Box<float>& box, uint32_t a, uint32_t hits) {
    while (__any_sync(kAllLanes, hits != 0)) {
      bool reported = false;
      uint32_t b = 0;
      if (hits != 0) {
        const SearchShared::Member& m = shared_.column[__ffs(hits) - 1];
        hits &= hits - 1;
        b = m.id;
        reported = source_.reports(work, box, a, {{m.lo_x, m.lo_y, m.lo_z}, {m.hi_x, m.hi_y, m.hi_z}}, b);
      }
      add(reported, a, b);
    }
  }

  /// Takes the last `count` <= 32 entries of the queue, one a lane.
  __device__ static uint64_t take(const WarpQueue& queue, unsigned& size, unsigned count) {
    size -= count;
    const uint64_t entry = lane_id() < count ? queue.entry[size + lane_id()] : 0;
    __syncwarp();
    return entry;
  }
  static constexpr uint64_t kIdMask = (1u << 30) - 1u;
  __device__ static uint32_t first_of(uint64_t pair) { return static_cast<uint32_t>(pair >> 30 & kIdMask); }
  __device__ static uint32_t second_of(uint64_t pair) { return static_cast<uint32_t>(pair & kIdMask); }

  __device__ void drain_pairs(unsigned count) {
    const uint64_t pair = take(shared_.pairs, pairs_, count);
    pair_count_ += count;
    const bool active = lane_id() < count;
    if constexpr (Sink::kTakesPairs) {
      if (active) sink_.take(first_of(pair), second_of(pair));
      __syncwarp();
    } else {
      uint32_t found = active ? sink_.expand(first_of(pair), second_of(pair)) : 0;
      while (__any_sync(kAllLanes, found != 0)) {
        const bool has = found != 0;
        const int test = __ffs(found) - 1;
        if (has) found &= found - 1;
        const uint64_t entry = pair | static_cast<uint64_t>(has ? test : 0) << 60;
        push(shared_.first, first_, has && test < Sink::kFirstOfSecondKind, entry);
        if (first_ >= 32) drain_first(32);
        push(shared_.second, second_, has && test >= Sink::kFirstOfSecondKind, entry);
        if (second_ >= 32) drain_second(32);
      }
    }
  }
  __device__ void drain_first(unsigned count) {
    const uint64_t entry = take(shared_.first, first_, count);
    first_count_ += count;
    if (lane_id() < count) sink_.take_first(first_of(entry), second_of(entry), static_cast<int>(entry >> 60));
    __syncwarp();
  }
  __device__ void drain_second(unsigned count) {
    const uint64_t entry = take(shared_.second, second_, count);
    second_count_ += count;
    if (lane_id() < count) sink_.take_second(first_of(entry), second_of(entry), static_cast<int>(entry >> 60));
    __syncwarp();
  }

  const Source& source_;
  const Sink& sink_;
  SearchShared& shared_;
  unsigned pairs_ = 0, first_ = 0, second_ = 0;
  uint64_t pair_count_ = 0, first_count_ = 0, second_count_ = 0;
};

constexpr unsigned kSearchBlock = 128;

/// `next` is the next item that no warp has taken yet.
template <class Source, class Sink>
__global__ void __launch_bounds__(kSearchBlock)
    pair_search_kernel(Counted items, uint64_t* next, Source source, Sink sink) {
  __shared__ SearchShared shared[kSearchBlock / 32];
  WarpSearch<Source, Sink> warp(source, sink, shared[threadIdx.x / 32]);
  const uint64_t n = source.is_put_off() ? 0 : items.size();
  const uint64_t warps = static_cast<uint64_t>(gridDim.x) * (kSearchBlock / 32);
  const uint64_t chunk = min(uint64_t{32}, max(uint64_t{1}, n / (8 * warps)));
  for (;;) {
    uint64_t first = 0;
    if (lane_id() == 0)
      first = atomicAdd(reinterpret_cast<unsigned long long*>(next), static_cast<unsigned long long>(chunk));
    first = __shfl_sync(kAllLanes, first, 0);
    if (first >= n || __any_sync(kAllLanes, sink.is_over())) break;
    const uint64_t end = min(n, first + chunk);
    for (uint64_t item = first; item < end; ++item) warp.search(item);
  }
  warp.finish();
}

}  // namespace collided
