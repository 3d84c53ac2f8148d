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

/// Entries that wait for a full warp: fewer than 32, and what one push may add, `each` a lane.
template <unsigned each>
struct WarpQueue {
  uint64_t entry[32 + 32 * each];
};

__device__ inline unsigned lane_id() { return threadIdx.x & 31u; }

/// Appends the values of the lanes with `has`.
__device__ inline void push(WarpQueue<1>& queue, unsigned& size, bool has, uint64_t value) {
  const unsigned lanes = __ballot_sync(kAllLanes, has);
  if (has) queue.entry[size + __popc(lanes & ((1u << lane_id()) - 1u))] = value;
  size += __popc(lanes);
  __syncwarp();
}

/// Appends an entry for each bit of the lanes' `tests`.
template <unsigned each>
__device__ void push_tests(WarpQueue<each>& queue, unsigned& size, uint32_t tests, uint64_t pair) {
  unsigned end = __popc(tests);
  for (int offset = 1; offset < 32; offset *= 2) {
    const unsigned before = __shfl_up_sync(kAllLanes, end, offset);
    if (lane_id() >= static_cast<unsigned>(offset)) end += before;
  }
  for (unsigned place = size + end - __popc(tests); tests != 0; tests &= tests - 1)
    queue.entry[place++] = pair | static_cast<uint64_t>(__ffs(tests) - 1) << 60;
  size += __shfl_sync(kAllLanes, end, 31);
  __syncwarp();
}

struct SearchShared {
  struct alignas(16) Member {
    float lo_x, lo_y, lo_z, hi_x, hi_y, hi_z;
    uint32_t id, unused;
  };
  Member column[kTile];
  WarpQueue<1> pairs;
  WarpQueue<6> first_tests;  ///< features whose boxes have to be tested
  WarpQueue<9> second_tests;
  WarpQueue<1> first, second;  ///< candidates
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
    if (pairs_ > 0) drain_pairs(pairs_);
    if constexpr (!Sink::kTakesPairs) {
      if (first_tests_ > 0) drain_first_tests(first_tests_);
      if (second_tests_ > 0) drain_second_tests(second_tests_);
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

  /// Takes the last `count` <= 32 entries of a queue, one a lane.
  struct Entry {
    bool active;
    uint32_t a, b;
    int test;
    uint64_t packed;
  };
  template <class Queue>
  __device__ static Entry take(const Queue& queue, unsigned& size, unsigned count) {
    constexpr uint64_t kIdMask = (1u << 30) - 1u;
    size -= count;
    const bool active = lane_id() < count;
    const uint64_t packed = active ? queue.entry[size + lane_id()] : 0;
    __syncwarp();
    return {active, static_cast<uint32_t>(packed >> 30 & kIdMask), static_cast<uint32_t>(packed & kIdMask),
            static_cast<int>(packed >> 60), packed};
  }

  __device__ void drain_pairs(unsigned count) {
    const Entry pair = take(shared_.pairs, pairs_, count);
    pair_count_ += count;
    if constexpr (Sink::kTakesPairs) {
      if (pair.active) sink_.take(pair.a, pair.b);
      __syncwarp();
    } else {
      const uint32_t tests = pair.active ? sink_.tests_of(pair.a, pair.b) : 0;
      constexpr uint32_t kFirstKind = (1u << Sink::kFirstOfSecondKind) - 1u;
      push_tests(shared_.first_tests, first_tests_, tests & kFirstKind, pair.packed);
      push_tests(shared_.second_tests, second_tests_, tests & ~kFirstKind, pair.packed);
      while (first_tests_ >= 32) drain_first_tests(32);
      while (second_tests_ >= 32) drain_second_tests(32);
    }
  }
  __device__ void drain_first_tests(unsigned count) {
    const Entry e = take(shared_.first_tests, first_tests_, count);
    push(shared_.first, first_, e.active && sink_.is_first(e.a, e.b, e.test), e.packed);
    if (first_ >= 32) drain_first(32);
  }
  __device__ void drain_second_tests(unsigned count) {
    const Entry e = take(shared_.second_tests, second_tests_, count);
    push(shared_.second, second_, e.active && sink_.is_second(e.a, e.b, e.test), e.packed);
    if (second_ >= 32) drain_second(32);
  }
  __device__ void drain_first(unsigned count) {
    const Entry e = take(shared_.first, first_, count);
    first_count_ += count;
    if (e.active) sink_.take_first(e.a, e.b, e.test);
    __syncwarp();
  }
  __device__ void drain_second(unsigned count) {
    const Entry e = take(shared_.second, second_, count);
    second_count_ += count;
    if (e.active) sink_.take_second(e.a, e.b, e.test);
    __syncwarp();
  }

  const Source& source_;
  const Sink& sink_;
  SearchShared& shared_;
  unsigned pairs_ = 0, first_tests_ = 0, second_tests_ = 0, first_ = 0, second_ = 0;
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
