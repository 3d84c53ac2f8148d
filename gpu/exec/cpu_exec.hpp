#pragma once
// The verbs of the engine on CPU cores (oneTBB). Same meaning as CudaExec, verb by verb.

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>
#include <string>
#include <vector>

#include "gpu/exec/atomic.hpp"
#include "gpu/exec/memory_ledger.hpp"

namespace collided {

class CpuExec {
 public:
  CpuExec(int threads, uint64_t memory_budget)
      : ledger_(memory_budget), arena_(threads > 0 ? threads : tbb::task_arena::automatic) {}

  DeviceInfo device() const {
    return {Backend::kCpu, "CPU, " + std::to_string(arena_.max_concurrency()) + " threads", 0};
  }

  void* allocate(const std::string& part, uint64_t bytes) {
    ledger_.take(part, bytes);
    void* memory = std::malloc(bytes);
    if (memory == nullptr) {
      ledger_.give_back(part, bytes);
      throw ResourceExhausted(part + ": the host has no " + std::to_string(bytes) + " bytes left");
    }
    return memory;
  }
  void deallocate(const std::string& part, void* memory, uint64_t bytes) {
    std::free(memory);
    ledger_.give_back(part, bytes);
  }
  const MemoryLedger& ledger() const { return ledger_; }

  /// f(i) for i in [0, n).
  template <class F>
  void for_each(const char*, uint64_t n, const F& f) {
    arena_.execute([&] {
      tbb::parallel_for(tbb::blocked_range<uint64_t>(0, n, kGrain), [&](const tbb::blocked_range<uint64_t>& range) {
        for (uint64_t i = range.begin(); i != range.end(); ++i) f(i);
      });
    });
  }

  /// f(item, rank) for every rank of every item: the paper's workload distribution. offsets[i] is the first
  /// unit of item i, offsets[items] the total.
  template <class F>
  void for_each_expanded(const char*, Span<const uint64_t> offsets, uint64_t total, const F& f) {
    const uint64_t* begin = offsets.data;
    const uint64_t* end = offsets.data + offsets.size();
    arena_.execute([&] {
      tbb::parallel_for(tbb::blocked_range<uint64_t>(0, total, kGrain), [&](const tbb::blocked_range<uint64_t>& range) {
        uint64_t item = static_cast<uint64_t>(std::upper_bound(begin, end, range.begin()) - begin) - 1;
        for (uint64_t unit = range.begin(); unit != range.end(); ++unit) {
          while (unit >= begin[item + 1]) ++item;
          f(item, unit - begin[item]);
        }
      });
    });
  }

  /// op over transform(i), i in [0, n); op must not depend on the order.
  template <class T, class F, class Op>
  T reduce(const char*, uint64_t n, const F& transform, const T& identity, const Op& op) {
    return arena_.execute([&] {
      return tbb::parallel_reduce(
          tbb::blocked_range<uint64_t>(0, n, kGrain), identity,
          [&](const tbb::blocked_range<uint64_t>& range, T value) {
            for (uint64_t i = range.begin(); i != range.end(); ++i) value = op(value, transform(i));
            return value;
          },
          op);
    });
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

  /// Ascending, in place.
  void sort(const char*, Span<uint64_t> keys) {
    arena_.execute([&] { tbb::parallel_sort(keys.data, keys.data + keys.size()); });
  }

  /// order[k] = place of the k-th smallest key; sorts the keys too.
  void sort_with_order(const char*, Span<uint64_t> keys, Span<uint32_t> order) {
    std::vector<std::pair<uint64_t, uint32_t>> both(keys.size());
    for (uint64_t i = 0; i < keys.size(); ++i) both[i] = {keys[i], static_cast<uint32_t>(i)};
    arena_.execute([&] { tbb::parallel_sort(both.begin(), both.end()); });
    for (uint64_t i = 0; i < keys.size(); ++i) {
      keys[i] = both[i].first;
      order[i] = both[i].second;
    }
  }

  template <class T>
  T read(const T* value) {
    return *value;
  }
  void upload(void* to, const void* from, uint64_t bytes) { copy(to, from, bytes); }
  void download(void* to, const void* from, uint64_t bytes) { copy(to, from, bytes); }
  void copy(void* to, const void* from, uint64_t bytes) {
    if (bytes != 0) std::memcpy(to, from, bytes);
  }
  void fill_zero(void* memory, uint64_t bytes) {
    if (bytes != 0) std::memset(memory, 0, bytes);
  }

  /// Runs one stage of the pipeline: cancellation before it, its time after it.
  template <class F>
  void stage(const char* name, const F& f) {
    if (cancelled && cancelled()) throw Cancelled();
    const auto start = std::chrono::steady_clock::now();
    f();
    const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - start;
    stages_.push_back({name, spent.count()});
  }
  void begin_frame() { stages_.clear(); }
  std::vector<StageTime> stage_times() { return stages_; }

  std::function<bool()> cancelled;

 private:
  static constexpr uint64_t kGrain = 512;
  MemoryLedger ledger_;
  tbb::task_arena arena_;
  std::vector<StageTime> stages_;
};

}  // namespace collided
