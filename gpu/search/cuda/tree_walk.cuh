#pragma once
// The search for pairs by walks through a tree, on a GPU. Walks differ in length by orders of magnitude; so the lanes
// of a warp share theirs. A lane that meets two nodes to go on from keeps one and leaves the other, a part of the walk,
// where any lane with nothing to do takes it: the last left first, so that few wait at a time. Pairs go through the
// queues of pair_queues.cuh.

#include "gpu/exec/cuda/step_clock.cuh"
#include "gpu/exec/cuda/warp_items.cuh"
#include "gpu/search/cuda/pair_queues.cuh"

namespace collided {

/// Walks that a warp takes at once, at least: all warps ask one counter for them.
constexpr unsigned kFewestWalks = 2;

/// Walks for a warp's lanes: the first of them by the warp's number, then fewer at a time the fewer there are left, so
/// that all warps end together.
class WarpWalks {
 public:
  /// `next`: a zeroed counter; `stop` as in is_stopped.
  __device__ WarpWalks(uint32_t count, uint64_t* next, const uint32_t* stop)
      : count_(count), warps_(gridDim.x * (blockDim.x / 32)), next_(next), stop_(stop) {
    const uint32_t chunk = chunk_of(count), warp = (blockIdx.x * blockDim.x + threadIdx.x) / 32;
    shared_from_ = min(count, chunk * warps_);
    hold(uint64_t{chunk} * warp, chunk);
  }

  __device__ bool are_over() const { return over_; }

  /// As WarpItems::take. `over`: no more, whatever there is.
  __device__ bool take(bool wants, bool over, uint32_t& walk) {
    if (held_.are_gone()) fetch(over);
    return held_.give(wants, walk);
  }

 private:
  __device__ uint32_t chunk_of(uint32_t left) const {
    constexpr uint32_t kMax = 32, kSharesOfWarp = 4;
    return min(kMax, max(kFewestWalks, left / (kSharesOfWarp * warps_)));
  }
  __device__ void hold(uint64_t first, uint32_t chunk) {
    held_.first = static_cast<uint32_t>(min(first, uint64_t{count_}));
    held_.end = min(count_, held_.first + chunk);
  }
  __device__ void fetch(bool over) {
    over = over | is_stopped(stop_);
    const uint32_t chunk = chunk_of(count_ - max(held_.end, shared_from_));  // as far as this warp knows
    hold(shared_from_ + take_items(next_, chunk), chunk);
    over_ = held_.are_gone() || __any_sync(kAllLanes, over);
    if (over_) held_.first = held_.end;
  }

  const uint32_t count_, warps_;
  uint64_t* const next_;
  const uint32_t* const stop_;
  uint32_t shared_from_;  ///< here begins what the counter hands out
  HeldItems<uint32_t> held_;
  bool over_ = false;
};

/// Memory of a warp.
template <class Part>
struct WalkShared {
  static constexpr unsigned kMaxWaiting = 160;  ///< seven blocks on a processor

  Part waiting[kMaxWaiting];
  PairQueuesShared queues;
};

template <class Source, class Sink>
class SharedWalks {
 public:
  using Shared = WalkShared<typename Source::Part>;

  __device__ SharedWalks(const Source& source, const Sink& sink, Shared& shared, const WarpWalks& walks)
      : source_(source), sink_(sink), shared_(shared), walks_(walks), pairs_(sink, shared.queues) {}

  __device__ void run() {
    for (;;) {
      take_waiting();
      if (!walks_.are_over()) take_new();
      if (__all_sync(kAllLanes, walk_.is_over()) && walks_.are_over()) break;
      go_on();
    }
    pairs_.finish();
    for (int offset = 16; offset > 0; offset /= 2) tests_ += __shfl_xor_sync(kAllLanes, tests_, offset);
    if (lane_id() == 0) source_.add_tests(tests_);
  }

 private:
  __device__ void take_waiting() {
    const bool wants = walk_.is_over();
    const unsigned lanes = __ballot_sync(kAllLanes, wants), rank = rank_among(lanes);
    const unsigned count = min(waiting_, static_cast<unsigned>(__popc(lanes)));
    if (wants && rank < count) walk_ = source_.resume(shared_.waiting[waiting_ - 1 - rank]);
    waiting_ -= count;
    __syncwarp();
  }
  __device__ void take_new() {
    if (!__any_sync(kAllLanes, walk_.is_over())) return;
    uint32_t walk = 0;
    const bool over = pairs_.is_overfull() || sink_.early_exit.is_over();
    if (walks_.take(walk_.is_over(), over, walk)) walk_ = source_.walk(walk);
  }
  /// Parts that any lane may take.
  __device__ void leave(const typename Source::Met& met) {
    const unsigned lanes = __ballot_sync(kAllLanes, met.has_other());
    if (met.has_other()) shared_.waiting[waiting_ + rank_among(lanes)] = {walk_.leaf, met.other};
    waiting_ += __popc(lanes);
    __syncwarp();
  }

  /// One meeting of each lane. Where no more parts may wait, all that is below what the lanes are to meet: each alone.
  __device__ void go_on() {
    const bool alone = waiting_ + 32 > Shared::kMaxWaiting;
    typename Source::Stretch stretch;
    if (alone) stretch = source_.stretch(walk_);
    do {
      typename Source::Met met;
      if (walk_.node != stretch.end) met = alone ? source_.meet_one(walk_) : source_.meet(walk_);
      tests_ += met.tests;
      pairs_.add_all(walk_.triangle, met.partners, [&](uint32_t k) { return k == 0 ? met.found[0] : met.found[1]; });
      leave(met);
    } while (alone && __any_sync(kAllLanes, walk_.node != stretch.end));
    if (alone) walk_.node = stretch.then;
  }

  const Source& source_;
  const Sink& sink_;
  Shared& shared_;
  WarpWalks walks_;
  PairQueues<Sink> pairs_;
  typename Source::Walk walk_;
  unsigned waiting_ = 0;
  uint64_t tests_ = 0;
};

/// `next`: a zeroed counter.
template <class Source, class Sink>
__global__ void __launch_bounds__(kSearchBlock)
    tree_walk_kernel(uint64_t* begin, uint64_t count, uint64_t* next, const uint32_t* stop, Source source, Sink sink) {
  note_begin(begin);
  __shared__ typename SharedWalks<Source, Sink>::Shared shared[kSearchBlock / 32];
  SharedWalks<Source, Sink>(source, sink, shared[threadIdx.x / 32], {static_cast<uint32_t>(count), next, stop}).run();
}

}  // namespace collided
