#pragma once
// The verbs of the engine (concepts.hpp) on CPU cores (oneTBB).

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "gpu/exec/atomic.hpp"
#include "gpu/exec/buffer.hpp"
#include "gpu/exec/concepts.hpp"
#include "gpu/exec/counted.hpp"
#include "gpu/exec/cpu/cpu_loops.hpp"
#include "gpu/exec/cpu/host_memory.hpp"
#include "gpu/exec/cpu/in_ranges.hpp"
#include "gpu/exec/cpu/radix_sort.hpp"
#include "gpu/exec/cpu/resumable.hpp"
#include "gpu/exec/cpu/staging.hpp"

namespace collided {

class CpuExec {
 public:
  CpuExec(int threads, MemoryLimits memory)
      : memory_(std::make_shared<MemoryLedger>(std::move(memory))), loops_(threads) {}

  DeviceInfo device() const { return {{}, "CPU, " + std::to_string(loops_.threads()) + " threads"}; }

  void* allocate(const std::string& part, uint64_t bytes) {
    ++allocations_;
    return memory_.allocate(part, bytes);
  }
  void deallocate(const std::string& part, void* memory, uint64_t bytes) { memory_.deallocate(part, memory, bytes); }
  static constexpr bool kLaunchesCost = false;
  static constexpr bool kRecordsLoops = true;
  const MemoryLedger& ledger() const { return *memory_.ledger(); }

  using Staging = HostStaging;
  Staging make_staging() const { return Staging(memory_.ledger()); }
  void done_with(Staging&) {}

  template <ItemFunctor F>
  void for_each(const char*, uint64_t n, const F& f) {
    if constexpr (HasRanges<F>)
      in_ranges(n, f);
    else
      loops_.for_each(n, kGrain, f);
  }

  template <ItemFunctor F>
  void for_each(const char* name, const Counted& n, const F& f) {
    for_each(name, n.size(), f);
  }

  template <GroupFunctor F>
  void for_each_group(const char*, const Counted& n, const F& f) {
    loops_.share(n.size(), 1, [&](LoopTurn& turn) {
      const auto shared = std::make_unique<typename F::Shared>();
      while (ItemRange* items = turn.next()) f(items->first++, Group{0, 1}, *shared);
    });
  }

  template <WalkingFunctor F>
  void for_each_part(const char* name, const Counted& n, const F& f) {
    for_each(name, n.size(), [&](uint64_t i) {
      const typename F::Item item = f.item(i);
      auto walk = item.walk();
      for (uint32_t k = 0; k < item.parts; ++k)
        if (const uint32_t found = found_in(f, walk.next()); found != kNothing) f.act(item, found);
    });
  }

  template <ManyPartsFunctor F>
  void for_each_of_many_parts(const char*, const Counted& n, const F& f) {
    loops_.share(n.size(), 1, [&](LoopTurn& turn) {
      while (ItemRange* items = turn.next()) do_parts(f, *items);
    });
  }

  template <ResumableFunctor F>
  void for_each_resumable(const char*, const Counted& n, uint64_t*, const F& f) {
    constexpr uint64_t kQueries = 32;  // of up to 64 iterations each
    if constexpr (HasRanges<F>)
      in_ranges(n.size(), f);
    else
      loops_.for_each(n.size(), kQueries, [&](uint64_t i) { do_resumable(f, i); });
  }

  template <class T, class F, class Op, class Then = NothingMore>
  void reduce_into(const char*, uint64_t n, const F& transform, const T& identity, const Op& op, T* result,
                   const Then& then = {}) {
    *result = loops_.reduce(n, kGrain, transform, identity, op);
    then(0);
  }

  template <class T>
  void exclusive_scan(const char*, Span<T> values) {
    T sum = 0;
    loops_.in_turn(values.size(), 1u << 18, [&](uint64_t first, uint64_t end) {
      for (uint64_t i = first; i < end; ++i) sum += std::exchange(values[i], sum);
    });
  }

  int sort_pairs(const char*, int, const SortArrays& arrays) {
    // The keys are dealt to `other_keys` first; from then on their own room is free to sort in.
    const KeyArrays<WritePairs> sorted{
        arrays.keys, arrays.other_keys, arrays.keys, {arrays.other_keys, arrays.other_values, arrays.values}};
    RadixSort(loops_, sorted).run();
    return 1;
  }

  template <class Write>
  void sort_keys(const char*, const Counted& count, KeyArrays<Write> arrays) {
    arrays.keys.count = count.size();
    RadixSort(loops_, arrays).run();
  }

  template <class F, class T>
  T step(uint64_t, const T* result, const F& enqueue) {
    return step_by_parts(result, enqueue);
  }
  static bool can_step(uint64_t) { return true; }
  template <class F, class T>
  T step_by_parts(const T* result, const F& f) {
    const WorkTime time(loops_.asks);
    f();
    step_milliseconds_ += time.milliseconds();
    return *result;
  }
  template <class T>
  T peek(const T* result) const {
    return *result;
  }
  double step_milliseconds() const { return step_milliseconds_; }
  uint32_t graph_launches() const { return 0; }

  void upload(void* to, const void* from, uint64_t bytes) { copy(to, from, bytes); }
  void download(void* to, const void* from, uint64_t bytes) { copy(to, from, bytes); }
  void download_async(void* to, const void* from, uint64_t bytes) { copy(to, from, bytes); }
  void wait() {}
  std::byte* host_memory(uint64_t bytes) {
    host_.ensure(bytes);
    return host_.data();
  }
  static std::shared_ptr<std::byte> host_block(uint64_t bytes) {
    constexpr uint64_t kAlignment = 64;
    auto* memory =
        static_cast<std::byte*>(std::aligned_alloc(kAlignment, (bytes + kAlignment - 1) / kAlignment * kAlignment));
    if (memory == nullptr) throw ResourceExhausted("answer: the host has no " + std::to_string(bytes) + " bytes left");
    return {memory, [](std::byte* block) { std::free(block); }};
  }
  void copy(void* to, const void* from, uint64_t bytes) {
    loops_.in_turn(bytes, kBytes, [&](uint64_t first, uint64_t end) {
      std::memcpy(static_cast<std::byte*>(to) + first, static_cast<const std::byte*>(from) + first, end - first);
    });
  }
  void fill_zero(void* memory, uint64_t bytes) {
    loops_.in_turn(bytes, kBytes, [&](uint64_t first, uint64_t end) {
      std::memset(static_cast<std::byte*>(memory) + first, 0, end - first);
    });
  }

  template <class F, class G>
  void concurrently(const F& f, const G& g) {
    f();
    g();
  }
  template <class F>
  void repeat(const uint64_t* again, const F& f) {
    do {
      loops_.asks.ask();
      f();
    } while (*again != 0);
  }

  template <class F>
  void stage(const char* name, const F& f) {
    loops_.asks.ask();
    const WorkTime time(loops_.asks);
    f();
    stages_.push_back({name, time.milliseconds()});
  }
  void make_current() {}
  void begin_frame() {
    stages_.clear();
    allocations_ = 0;
    step_milliseconds_ = 0;
  }
  template <class F>
  auto frame(const F& f) {
    begin_frame();
    return f();
  }
  uint32_t allocations() const { return allocations_; }
  std::vector<StageTime> stage_times() { return stages_; }

  Asks& asks() { return loops_.asks; }
  CpuLoops& host_loops() { return loops_; }

 private:
  static constexpr uint64_t kGrain = 512;
  static constexpr uint64_t kBytes = 4u << 20;  ///< that are copied at a time

  struct WritePairs {
    Span<uint64_t> keys;
    Span<uint32_t> values;
    Span<const uint32_t> given;

    bool has_data() const { return !given.empty(); }
    void operator()(uint64_t place, uint64_t key, uint64_t from) const {
      keys[place] = key;
      if (has_data()) values[place] = given[from];
    }
  };

  template <HasRanges F>
  void in_ranges(uint64_t n, const F& f) {
    loops_.for_each_range(n, InRanges<F>::kItems,
                          [&](uint64_t first, uint64_t end) { InRanges<F>::run(f, first, end); });
  }

  /// Parts of the first item that take a bounded time.
  template <class F>
  static void do_parts(const F& f, ItemRange& items) {
    constexpr uint64_t kParts = 1u << 16;
    const typename F::Item item = f.item(items.first);
    const uint64_t end = std::min<uint64_t>(item.parts, items.part + kParts);
    auto walk = item.walk_from(static_cast<uint32_t>(items.part));
    for (; items.part < end; ++items.part)
      if (const uint32_t found = found_in(f, walk.next()); found != kNothing) f.act(item, found);
    if (end == item.parts) ++items.first, items.part = 0;
  }

  HostMemory memory_;
  CpuLoops loops_;
  std::vector<StageTime> stages_;
  Buffer<std::byte, CpuExec> host_{*this, "downloads"};
  double step_milliseconds_ = 0;
  uint32_t allocations_ = 0;
};

static_assert(Executor<CpuExec> && SortsKeys<CpuExec>);

}  // namespace collided
