#pragma once
// Pairs, and then the candidates that come of them, on their way to a sink. They are gathered in shared memory until
// there are enough for all lanes, so that every step works with full warps and a list is appended to by a warp at a
// time.

#include "gpu/exec/cuda/warp.cuh"
#include "gpu/search/neighbours.hpp"

namespace collided {

/// Entries that wait for a full warp: fewer than 32, and what one push may add, `each` a lane.
template <unsigned each>
struct WarpQueue {
  uint64_t entry[32 + 32 * each];
};

/// Appends the values of the lanes with `has`.
template <unsigned each>
__device__ void push(WarpQueue<each>& queue, unsigned& size, bool has, uint64_t value) {
  const unsigned lanes = __ballot_sync(kAllLanes, has);
  if (has) queue.entry[size + rank_among(lanes)] = value;
  size += __popc(lanes);
  __syncwarp();
}

/// Places for a few entries of each lane, at most `most` of them, behind `size`.
template <unsigned most>
__device__ unsigned claim(unsigned& size, unsigned count) {
  unsigned before = 0, all = 0;
  for (unsigned bit = 1; bit <= most; bit *= 2) {
    const unsigned lanes = __ballot_sync(kAllLanes, (count & bit) != 0);
    before += bit * rank_among(lanes);
    all += bit * __popc(lanes);
  }
  const unsigned place = size + before;
  size += all;
  return place;
}

/// Appends an entry for each bit of the lanes' `tests`.
template <unsigned each>
__device__ void push_tests(WarpQueue<each>& queue, unsigned& size, uint32_t tests, uint64_t pair) {
  for (unsigned place = claim<each>(size, __popc(tests)); tests != 0; tests &= tests - 1)
    queue.entry[place++] = pair | static_cast<uint64_t>(__ffs(tests) - 1) << (2 * PackedTest::kIdBits);
  __syncwarp();
}

/// Pairs that a lane hands over at once, at most.
constexpr unsigned kPairsAtOnce = 4;

/// Memory of a warp.
struct PairQueuesShared {
  WarpQueue<kPairsAtOnce> pairs;
  WarpQueue<6> first_tests;  ///< features whose boxes have to be tested
  WarpQueue<9> second_tests;
  WarpQueue<1> first, second;  ///< candidates, but for those that are left out
};

/// All lanes of the warp call together.
template <class Sink>
class PairQueues {
 public:
  __device__ PairQueues(const Sink& sink, PairQueuesShared& shared) : sink_(sink), shared_(shared) {}

  /// The pairs of the lanes with `found`.
  __device__ void add(bool found, uint32_t a, uint32_t b) {
    push(shared_.pairs, pairs_, found, pack(a, b));
    if (pairs_ >= 32) drain_pairs(32);
  }

  /// The pairs of a with those that its lane's bits stand for.
  template <class IdOf>
  __device__ void add_all(uint32_t a, uint32_t bits, const IdOf& id_of) {
    while (__any_sync(kAllLanes, bits != 0)) {
      unsigned count = min(kPairsAtOnce, static_cast<unsigned>(__popc(bits)));
      for (unsigned place = claim<kPairsAtOnce>(pairs_, count); count > 0; --count, bits &= bits - 1) {
        const uint32_t b = id_of(__ffs(bits) - 1);
        shared_.pairs.entry[place++] = pack(a, b);
      }
      __syncwarp();
      while (pairs_ >= 32) drain_pairs(32);
    }
  }

  /// Tests of features (PackedTest), one of each active lane.
  __device__ void test_first(bool active, uint64_t packed) {
    const PackedTest e = PackedTest::unpacked(packed);
    push(shared_.first, first_, active && sink_.overlap_first(e.a, e.b, e.test), packed);
    if (first_ >= 32) drain_first(32);
  }
  __device__ void test_second(bool active, uint64_t packed) {
    const PackedTest e = PackedTest::unpacked(packed);
    push(shared_.second, second_, active && sink_.overlap_second(e.a, e.b, e.test + Sink::kFirstOfSecondKind), packed);
    if (second_ >= 32) drain_second(32);
  }

  /// Whether this lane has seen that a list holds more than is of use (AppendList::push). A lane knows of what it
  /// pushed itself: reading the lists' counters would wait behind the atomics of all warps.
  __device__ bool is_overfull() const { return overfull_; }

  /// After the last pair.
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
  /// Takes the last `count` <= 32 entries of a queue, one a lane.
  struct Entry : PackedTest {
    bool active;
    uint64_t packed;
  };
  __device__ static uint64_t pack(uint32_t a, uint32_t b) { return PackedTest{min(a, b), max(a, b), 0}.packed(); }
  template <class Queue>
  __device__ static Entry take(const Queue& queue, unsigned& size, unsigned count) {
    size -= count;
    const bool active = lane_id() < count;
    const uint64_t packed = active ? queue.entry[size + lane_id()] : 0;
    __syncwarp();
    return {PackedTest::unpacked(packed), active, packed};
  }

  __device__ void drain_pairs(unsigned count) {
    const Entry pair = take(shared_.pairs, pairs_, count);
    pair_count_ += count;
    if constexpr (Sink::kTakesPairs) {
      overfull_ |= pair.active && !sink_.take(pair.a, pair.b);
      __syncwarp();
    } else {
      const uint32_t tests = pair.active ? sink_.tests_of(pair.a, pair.b) : 0;
      constexpr uint32_t kFirstKind = (1u << Sink::kFirstOfSecondKind) - 1u;
      push_tests(shared_.first_tests, first_tests_, tests & kFirstKind, pair.packed);
      push_tests(shared_.second_tests, second_tests_, tests >> Sink::kFirstOfSecondKind, pair.packed);
      while (first_tests_ >= 32) drain_first_tests(32);
      while (second_tests_ >= 32) drain_second_tests(32);
    }
  }
  __device__ void drain_first_tests(unsigned count) {
    const Entry e = take(shared_.first_tests, first_tests_, count);
    test_first(e.active, e.packed);
  }
  __device__ void drain_second_tests(unsigned count) {
    const Entry e = take(shared_.second_tests, second_tests_, count);
    test_second(e.active, e.packed);
  }
  __device__ void drain_first(unsigned count) {
    const Entry e = take(shared_.first, first_, count);
    const bool is_candidate = e.active && !sink_.excludes_first(e.a, e.b, e.test);
    first_count_ += __popc(__ballot_sync(kAllLanes, is_candidate));
    overfull_ |= is_candidate && !sink_.take_first(e.a, e.b, e.test);
    __syncwarp();
  }
  __device__ void drain_second(unsigned count) {
    const Entry e = take(shared_.second, second_, count);
    const int test = e.test + Sink::kFirstOfSecondKind;
    const bool is_candidate = e.active && !sink_.excludes_second(e.a, e.b, test);
    second_count_ += __popc(__ballot_sync(kAllLanes, is_candidate));
    overfull_ |= is_candidate && !sink_.take_second(e.a, e.b, test);
    __syncwarp();
  }

  const Sink& sink_;
  PairQueuesShared& shared_;
  unsigned pairs_ = 0, first_tests_ = 0, second_tests_ = 0, first_ = 0, second_ = 0;
  bool overfull_ = false;
  uint64_t pair_count_ = 0, first_count_ = 0, second_count_ = 0;
};

constexpr unsigned kSearchBlock = 128;

}  // namespace collided
