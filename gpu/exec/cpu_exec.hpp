#pragma once
// The verbs of the engine on CPU cores (oneTBB). Same meaning as CudaExec, verb by verb.

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "gpu/exec/atomic.hpp"
#include "gpu/exec/buffer.hpp"
#include "gpu/exec/counted.hpp"
#include "gpu/exec/host_memory.hpp"
#include "gpu/exec/in_steps.hpp"
#include "gpu/exec/key_order.hpp"
#include "gpu/exec/pair_search.hpp"
#include "gpu/exec/pair_taker.hpp"
#include "gpu/exec/radix_sort.hpp"
#include "gpu/exec/staging.hpp"
#include "gpu/exec/step_key.hpp"
#include "gpu/exec/tree_walk.hpp"

namespace collided {

class CpuExec {
 public:
  CpuExec(int threads, MemoryLimits memory)
      : memory_(std::make_shared<MemoryLedger>(std::move(memory))),
        arena_(threads > 0 ? threads : tbb::task_arena::automatic) {}

  DeviceInfo device() const {
    return {Backend::kCpu, "CPU, " + std::to_string(arena_.max_concurrency()) + " threads", 0};
  }

  void* allocate(const std::string& part, uint64_t bytes) {
    ++allocations_;
    return memory_.allocate(part, bytes);
  }
  void deallocate(const std::string& part, void* memory, uint64_t bytes) { memory_.deallocate(part, memory, bytes); }
  /// Whether a verb takes its time even where there is nothing to do.
  static constexpr bool kLaunchesCost = false;
  const MemoryLedger& ledger() const { return *memory_.ledger(); }

  /// For positions on their way; from any thread. May outlive this.
  using Staging = HostStaging;
  Staging make_staging() const { return Staging(memory_.ledger()); }
  /// What was put in line so far is the last that reads what the staging brought.
  void done_with(Staging&) {}

  /// f(i) for i in [0, n).
  template <class F>
  void for_each(const char*, uint64_t n, const F& f) {
    arena_.execute([&] {
      tbb::parallel_for(tbb::blocked_range<uint64_t>(0, n, kGrain), [&](const tbb::blocked_range<uint64_t>& range) {
        for (uint64_t i = range.begin(); i != range.end(); ++i) f(i);
      });
    });
  }

  template <class F>
  void for_each(const char* name, const Counted& n, const F& f) {
    for_each(name, n.size(), f);
  }

  /// f(i, group, shared) for i in [0, n): groups of threads that share memory (Group).
  template <class F>
  void for_each_group(const char*, const Counted& n, const F& f) {
    arena_.execute([&] {
      tbb::parallel_for(tbb::blocked_range<uint64_t>(0, n.size(), 1), [&](const tbb::blocked_range<uint64_t>& range) {
        const auto shared = std::make_unique<typename F::Shared>();
        for (uint64_t i = range.begin(); i != range.end(); ++i) f(i, Group{0, 1}, *shared);
      });
    });
  }

  /// For i in [0, n), item = f.item(i), part = item.part(k), k in [0, item.parts): f.act(item, found), where found is
  /// f.find(part, f.look(part)) and not kNothing. item.walk().next() are the same parts in turn.
  template <class F>
  void for_each_part(const char* name, const Counted& n, const F& f) {
    for_each(name, n.size(), [&](uint64_t i) {
      const typename F::Item item = f.item(i);
      auto walk = item.walk();
      for (uint32_t k = 0; k < item.parts; ++k)
        if (const uint32_t found = found_in(f, walk.next()); found != kNothing) f.act(item, found);
    });
  }

  /// f.begin(i, state), then f.step(state) until state.is_over(), then f.finish(state), for i in [0, n); no step if
  /// begin() leaves the state as it was.
  template <class F>
  void for_each_in_steps(const char* name, const Counted& n, uint64_t*, const F& f) {
    for_each(name, n.size(), [&](uint64_t i) { do_in_steps(f, i); });
  }

  /// The pairs of a source's items, handed to a sink (pair_search.hpp).
  template <class Source, class Sink>
  void search(const char*, const Counted& items, uint64_t*, const Source& source, const Sink& sink) {
    if (source.is_put_off()) return;
    share_among_takers(items.size(), 8, sink, source.boxes.size(), [&](const auto& range, auto& taker) {
      LeafTiles tiles;
      for (uint64_t i = range.begin(); i != range.end() && !sink.is_over(); ++i)
        visit_item(
            source, i, tiles, [&](uint32_t a, uint32_t b) { taker.take(a, b); },
            [&](uint32_t triangle) { taker.expect(triangle); });
    });
  }

  /// The same for the walks of a source's items (tree_walk.hpp).
  template <class Source, class Sink>
  void walk(const char*, uint64_t items, uint64_t*, const Source& source, const Sink& sink) {
    share_among_takers(items, 64, sink, items, [&](const auto& range, auto& taker) {
      uint64_t steps = 0;
      for (uint64_t i = range.begin(); i != range.end() && !sink.is_over(); ++i)
        steps += walk_item(source, i, [&](uint32_t a, uint32_t b) { taker.take(a, b); });
      source.add_tests(steps);
    });
  }

  /// *result = op over transform(i), i in [0, n); op must not depend on the order. Then then(0).
  template <class T, class F, class Op, class Then = NothingMore>
  void reduce_into(const char*, uint64_t n, const F& transform, const T& identity, const Op& op, T* result,
                   const Then& then = {}) {
    *result = arena_.execute([&] {
      return tbb::parallel_reduce(
          tbb::blocked_range<uint64_t>(0, n, kGrain), identity,
          [&](const tbb::blocked_range<uint64_t>& range, T value) {
            for (uint64_t i = range.begin(); i != range.end(); ++i) value = op(value, transform(i));
            return value;
          },
          op);
    });
    then(0);
  }

  /// In place.
  template <class T>
  void exclusive_scan(const char*, Span<T> values) {
    T sum = 0;
    for (uint64_t i = 0; i < values.size(); ++i) {
      const T value = values[i];
      values[i] = sum;
      sum += value;
    }
  }

  /// Stably by the lowest `bits` of the keys; 0 if the result is in `keys` and `values`, 1 if it is in the others.
  int sort_pairs(const char*, int bits, const SortArrays& arrays) {
    return arena_.execute([&] { return RadixSort(arrays).run(bits); });
  }

  /// The first `count` keys in ascending order, with their data; false if they do not fit the way it is done.
  template <class Data>
  bool sort_keys(const char*, const Counted& count, KeyArrays<Data> arrays) {
    arrays.keys.count = count.size();
    return arena_.execute([&] { return KeyOrder(arrays).run(); });
  }
  static constexpr bool kSortsKeys = true;

  /// Runs a step, stages named within, and returns what it left at `result`.
  template <class F, class T>
  T step(const StepKey&, const T* result, const F& enqueue) {
    const auto start = std::chrono::steady_clock::now();
    enqueue();
    step_milliseconds_ = milliseconds_since(start);
    return *result;
  }
  double step_milliseconds() const { return step_milliseconds_; }
  uint32_t graph_launches() const { return 0; }

  void upload(void* to, const void* from, uint64_t bytes) { copy(to, from, bytes); }
  void download(void* to, const void* from, uint64_t bytes) { copy(to, from, bytes); }
  void download_async(void* to, const void* from, uint64_t bytes) { copy(to, from, bytes); }
  void wait() {}
  /// Memory of the host for downloads, until the next call.
  std::byte* host_memory(uint64_t bytes) {
    host_.resize(std::max<size_t>(host_.size(), bytes));
    return host_.data();
  }
  void copy(void* to, const void* from, uint64_t bytes) {
    if (bytes != 0) std::memcpy(to, from, bytes);
  }
  void fill_zero(void* memory, uint64_t bytes) {
    if (bytes != 0) std::memset(memory, 0, bytes);
  }

  /// Two things that do not depend on each other.
  template <class F, class G>
  void beside(const F& f, const G& g) {
    f();
    g();
  }

  /// Runs one stage of the pipeline: cancellation before it, its time after it.
  template <class F>
  void stage(const char* name, const F& f) {
    if (cancelled && cancelled()) throw Cancelled();
    const auto start = std::chrono::steady_clock::now();
    f();
    stages_.push_back({name, milliseconds_since(start)});
  }
  void begin_frame() {
    stages_.clear();
    allocations_ = 0;
  }
  /// Runs one frame: begin_frame(), then f().
  template <class F>
  auto frame(const F& f) {
    begin_frame();
    return f();
  }
  uint32_t allocations() const { return allocations_; }
  std::vector<StageTime> stage_times() { return stages_; }

  std::function<bool()> cancelled;

 private:
  static constexpr uint64_t kGrain = 512;
  static double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }

  /// use(range, taker) for ranges of items, by several threads (pair_taker.hpp).
  template <class Sink, class Use>
  void share_among_takers(uint64_t items, uint64_t grain, const Sink& sink, uint64_t triangles, const Use& use) {
    const auto run = [&](const auto&... features) {
      arena_.execute([&] {
        tbb::parallel_for(tbb::blocked_range<uint64_t>(0, items, grain),
                          [&](const tbb::blocked_range<uint64_t>& range) {
                            Taker<Sink> taker(sink, features...);
                            use(range, taker);
                            taker.finish();
                          });
      });
    };
    if constexpr (Sink::kTakesPairs)
      run();
    else
      run(prepare_features(sink, triangles));
  }
  template <class Sink>
  auto prepare_features(const Sink& sink, uint64_t triangles) {
    using Features = typename Taker<Sink>::Features;
    features_.ensure(triangles * sizeof(Features));
    Features* features = reinterpret_cast<Features*>(features_.data());
    for_each("prepare_features", triangles,
             [&](uint64_t i) { new (&features[i]) Features(feature_boxes_of(sink.tests, static_cast<uint32_t>(i))); });
    return features;
  }

  HostMemory memory_;
  tbb::task_arena arena_;
  std::vector<StageTime> stages_;
  std::vector<std::byte> host_;
  Buffer<std::byte, CpuExec> features_{*this, "features"};  ///< FeatureBoxes of each triangle
  double step_milliseconds_ = 0;
  uint32_t allocations_ = 0;
};

}  // namespace collided
