#pragma once
// A backend that computes nothing: it books the memory that it is asked for, and notes the stages. What a step of a
// scene holds and runs is known from it before the scene is made, from the code that makes it.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gpu/exec/concepts.hpp"
#include "gpu/exec/cpu/cpu_loops.hpp"
#include "gpu/exec/cpu/staging.hpp"

namespace collided {

/// In place of this backend. Memory that only the backend itself takes, as scratch of a GPU's library, is not booked.
template <Backend backend>
class DryRun {
 public:
  DeviceInfo device() const { return {{backend, 0}}; }
  static constexpr bool kLaunchesCost = backend == Backend::kCuda;
  static constexpr bool kRecordsLoops = true;

  /// An address that nobody reads or writes: other addresses are formed from it.
  void* allocate(const std::string& part, uint64_t bytes) {
    constexpr uintptr_t kNowhere = 4096;
    ledger_->take(part, bytes);
    return reinterpret_cast<void*>(kNowhere);
  }
  void deallocate(const std::string& part, void*, uint64_t bytes) { ledger_->give_back(part, bytes); }
  const MemoryLedger& ledger() const { return *ledger_; }
  std::byte* host_memory(uint64_t) { return nullptr; }
  static std::shared_ptr<std::byte> host_block(uint64_t) { return nullptr; }
  uint32_t allocations() const { return 0; }

  using Staging = HostStaging;
  Staging make_staging() const { return Staging(ledger_); }
  void done_with(Staging&) {}

  void upload(void*, const void*, uint64_t) {}
  void download(void*, const void*, uint64_t) {}
  void download_async(void*, const void*, uint64_t) {}
  void copy(void*, const void*, uint64_t) {}
  void fill_zero(void*, uint64_t) {}
  void wait() {}

  template <class Length, class F>
  void for_each(const char*, const Length&, const F&) {}
  template <class F>
  void for_each_group(const char*, const Counted&, const F&) {}
  template <class F>
  void for_each_part(const char*, const Counted&, const F&) {}
  template <class F>
  void for_each_of_many_parts(const char*, const Counted&, const F&) {}
  template <class F>
  void for_each_resumable(const char*, const Counted&, uint64_t*, const F&) {}

  template <class F, class T, class Op, class Then = NothingMore>
  void reduce_into(const char*, uint64_t, const F&, const T&, const Op&, T*, const Then& = {}) {}
  template <class T>
  void exclusive_scan(const char*, Span<T>) {}
  int sort_pairs(const char*, int, const SortArrays&) { return 0; }
  template <class Write>
  void sort_keys(const char*, const Counted&, KeyArrays<Write>) requires(backend == Backend::kCpu) {}

  void make_current() {}
  void begin_frame() { stages_.clear(); }
  template <class F>
  auto frame(const F& f) {
    begin_frame();
    return f();
  }
  /// The result of a step that found nothing.
  template <class F, class T>
  T step(uint64_t, const T*, const F& enqueue) {
    enqueue();
    return T{};
  }
  static bool can_step(uint64_t) { return true; }
  template <class F, class T>
  T step_by_parts(const T*, const F& f) {
    f();
    return T{};
  }
  template <class T>
  T peek(const T*) const {
    return T{};
  }
  template <class F>
  void stage(const char* name, const F& f) {
    stages_.push_back({name, 0});
    f();
  }
  template <class F, class G>
  void concurrently(const F& f, const G& g) {
    f();
    g();
  }
  template <class F>
  void repeat(const uint64_t*, const F& f) {
    f();
  }
  std::vector<StageTime> stage_times() { return stages_; }
  double step_milliseconds() const { return 0; }
  uint32_t graph_launches() const { return 0; }
  Asks& asks() { return loops_.asks; }
  CpuLoops& host_loops() { return loops_; }

 private:
  const std::shared_ptr<MemoryLedger> ledger_ = std::make_shared<MemoryLedger>(MemoryLimits(0));
  std::vector<StageTime> stages_;
  CpuLoops loops_{1};
};

static_assert(Executor<DryRun<Backend::kCpu>> && SortsKeys<DryRun<Backend::kCpu>>);
static_assert(Executor<DryRun<Backend::kCuda>> && !SortsKeys<DryRun<Backend::kCuda>>);

}  // namespace collided
