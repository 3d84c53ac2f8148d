#pragma once
// The search for pairs on a GPU. A warp takes an item: each lane holds a row's box, the columns' boxes pass by in
// shared memory. What it finds goes through the warp's queues.

#include <cuda_runtime.h>

#include "gpu/base/box.hpp"
#include "gpu/base/tiles.hpp"
#include "gpu/exec/counted.hpp"
#include "gpu/exec/cuda/step_clock.cuh"
#include "gpu/exec/cuda/warp_items.cuh"
#include "gpu/search/cuda/pair_queues.cuh"

namespace collided {

struct SearchShared {
  struct alignas(16) Member {
    float lo_x, lo_y, lo_z, hi_x, hi_y, hi_z;
    uint32_t id, axes;
  };
  Member column[kTile];
  PairQueuesShared queues;
};

template <class Source, class Sink>
class WarpSearch {
 public:
  __device__ WarpSearch(const Source& source, const Sink& sink, SearchShared& shared)
      : source_(source), shared_(shared), pairs_(sink, shared.queues) {}

  /// A share of an item's work: one in `shares` of the columns of each tile.
  __device__ void search(uint64_t item, uint32_t share, uint32_t shares) {
    const auto work = source_.work(item);
    const uint32_t mine = work.row + lane_id();
    const bool has_row = mine < work.leaf.count;
    const uint32_t a = has_row ? work.members[mine] : 0;
    const Box<float> box = source_.boxes[a];
    const uint32_t axes = source_.axes_of_start(work, box);
    for (uint32_t first = work.first_column; first < work.end_column; first += kTile) {
      const uint32_t columns = load_columns(work, first);
      uint32_t hits = 0;
      const uint32_t end = min(columns, (share + 1) * (kTile / shares));
      for (uint32_t k = share * (kTile / shares); k < end; ++k) {
        const SearchShared::Member& m = shared_.column[k];
        hits |= (overlaps(box, m) && Source::reports(axes, m.axes) ? 1u : 0u) << k;
      }
      if (first == work.row) hits &= ~0u << lane_id() << 1;  // a tile with itself: only those after this one
      if (source_.filter.has_rules() || !work.is_own) hits = allowed(a, hits, work.is_own);
      pairs_.add_all(a, has_row ? hits : 0, [&](uint32_t k) { return shared_.column[k].id; });
      __syncwarp();
    }
  }

  /// Whether what is left is in vain (PairQueues::is_overfull).
  __device__ bool is_overfull() const { return pairs_.is_overfull(); }

  /// After the last item.
  __device__ void finish() { pairs_.finish(); }

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
      shared_.column[lane_id()] = {box.lo.x, box.lo.y, box.lo.z, box.hi.x,
                                   box.hi.y, box.hi.z, id,       source_.axes_of_start(work, box)};
    }
    __syncwarp();
    return columns;
  }

  /// Those of the hits that the filter lets pass.
  __device__ uint32_t allowed(uint32_t a, uint32_t hits, bool is_own) const {
    uint32_t kept = 0;
    for (; hits != 0; hits &= hits - 1) {
      const uint32_t k = __ffs(hits) - 1;
      kept |= (source_.filter(a, shared_.column[k].id, is_own) ? 1u : 0u) << k;
    }
    return kept;
  }

  const Source& source_;
  SearchShared& shared_;
  PairQueues<Sink> pairs_;
};

/// `next` as in take_items.
template <class Source, class Sink>
__global__ void __launch_bounds__(kSearchBlock)
    pair_search_kernel(uint64_t* begin, Counted items, uint64_t* next, const uint32_t* stop, Source source, Sink sink) {
  note_begin(begin);
  __shared__ SearchShared shared[kSearchBlock / 32];
  WarpSearch<Source, Sink> warp(source, sink, shared[threadIdx.x / 32]);
  const uint64_t warps = static_cast<uint64_t>(gridDim.x) * (kSearchBlock / 32);
  // Where items are few, one with many pairs would be all that is left to do in the end.
  const uint64_t whole = source.must_rerun() ? 0 : items.size();
  const uint32_t shares = whole < 4 * warps ? 4 : whole < 8 * warps ? 2 : 1;
  const uint64_t n = whole * shares;
  const uint64_t chunk = min(uint64_t{32}, max(uint64_t{1}, n / (8 * warps)));
  for (;;) {
    const bool over = warp.is_overfull() | sink.early_exit.is_over() | is_stopped(stop);
    const uint64_t first = take_items(next, chunk);
    if (first >= n || __any_sync(kAllLanes, over)) break;
    const uint64_t end = min(n, first + chunk);
    for (uint64_t i = first; i < end; ++i) warp.search(i / shares, static_cast<uint32_t>(i % shares), shares);
  }
  warp.finish();
}

}  // namespace collided
