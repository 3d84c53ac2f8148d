#pragma once
// Counters that many threads add to, and lists that many threads append to.

#ifndef __CUDA_ARCH__
#include <atomic>
#endif

#include "gpu/base/host_device.hpp"

namespace collided {

/// Adds and returns the value before. Relaxed: the end of a stage orders everything.
COLLIDED_HD inline uint32_t atomic_add(uint32_t& target, uint32_t value) {
#ifdef __CUDA_ARCH__
  return atomicAdd(&target, value);
#else
  return std::atomic_ref<uint32_t>(target).fetch_add(value, std::memory_order_relaxed);
#endif
}

COLLIDED_HD inline uint64_t atomic_add(uint64_t& target, uint64_t value) {
#ifdef __CUDA_ARCH__
  return atomicAdd(reinterpret_cast<unsigned long long*>(&target), static_cast<unsigned long long>(value));
#else
  return std::atomic_ref<uint64_t>(target).fetch_add(value, std::memory_order_relaxed);
#endif
}

COLLIDED_HD inline void atomic_min(uint64_t& target, uint64_t value) {
#ifdef __CUDA_ARCH__
  atomicMin(reinterpret_cast<unsigned long long*>(&target), static_cast<unsigned long long>(value));
#else
  std::atomic_ref<uint64_t> least(target);
  uint64_t seen = least.load(std::memory_order_relaxed);
  while (value < seen && !least.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
  }
#endif
}

COLLIDED_HD inline void atomic_min(uint32_t& target, uint32_t value) {
#ifdef __CUDA_ARCH__
  atomicMin(&target, value);
#else
  std::atomic_ref<uint32_t> least(target);
  uint32_t seen = least.load(std::memory_order_relaxed);
  while (value < seen && !least.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
  }
#endif
}

/// Becomes `value` where it is `expected`. Returns the value before.
COLLIDED_HD inline uint32_t atomic_claim(uint32_t& target, uint32_t expected, uint32_t value) {
#ifdef __CUDA_ARCH__
  return atomicCAS(&target, expected, value);
#else
  std::atomic_ref<uint32_t>(target).compare_exchange_strong(expected, value, std::memory_order_relaxed);
  return expected;
#endif
}

/// Swaps; the thread that finds another's value sees all that the other one wrote before.
COLLIDED_HD inline uint32_t exchange_in_order(uint32_t& target, uint32_t value) {
#ifdef __CUDA_ARCH__
  __threadfence();
  const uint32_t before = atomicExch(&target, value);
  __threadfence();
  return before;
#else
  return std::atomic_ref<uint32_t>(target).exchange(value, std::memory_order_acq_rel);
#endif
}

/// Read while others write.
template <class T>
COLLIDED_HD T atomic_read(T& value) {
#ifdef __CUDA_ARCH__
  return *static_cast<volatile T*>(&value);
#else
  return std::atomic_ref<T>(value).load(std::memory_order_relaxed);
#endif
}

template <class T>
COLLIDED_HD void atomic_write(T& target, T value) {
#ifdef __CUDA_ARCH__
  *static_cast<volatile T*>(&target) = value;
#else
  std::atomic_ref<T>(target).store(value, std::memory_order_relaxed);
#endif
}

/// One slot for each calling thread; a warp's threads that get here together share one atomic.
COLLIDED_HD inline uint64_t claim_slot(uint64_t& count) {
#ifdef __CUDA_ARCH__
  const unsigned active = __activemask();
  const unsigned lane = threadIdx.x & 31u;
  const int leader = __ffs(static_cast<int>(active)) - 1;
  unsigned long long base = 0;
  if (static_cast<int>(lane) == leader) base = atomic_add(count, static_cast<uint64_t>(__popc(active)));
  base = __shfl_sync(active, base, leader);
  return base + __popc(active & ((1u << lane) - 1u));
#else
  return atomic_add(count, uint64_t{1});
#endif
}

/// Adds one to a counter and returns the value before; threads of a warp that count in the same place share one
/// atomic. Neighbours often do, and one place takes no more than about an atomic a nanosecond.
COLLIDED_HD inline uint32_t count_up(const Span<uint32_t>& counters, uint32_t place) {
#ifdef __CUDA_ARCH__
  const unsigned same = __match_any_sync(__activemask(), place);
  const unsigned lane = threadIdx.x & 31u;
  const int leader = __ffs(static_cast<int>(same)) - 1;
  uint32_t base = 0;
  if (static_cast<int>(lane) == leader) base = atomicAdd(&counters[place], static_cast<uint32_t>(__popc(same)));
  base = __shfl_sync(same, base, leader);
  return base + static_cast<uint32_t>(__popc(same & ((1u << lane) - 1u)));
#else
  return atomic_add(counters[place], 1u);
#endif
}

/// The same where nobody asks for the value before: the thread goes on without waiting for the memory.
COLLIDED_HD inline void count_in(const Span<uint32_t>& counters, uint32_t place) {
#ifdef __CUDA_ARCH__
  const unsigned same = __match_any_sync(__activemask(), place);
  if ((threadIdx.x & 31u) == static_cast<unsigned>(__ffs(static_cast<int>(same)) - 1))
    atomicAdd(&counters[place], static_cast<uint32_t>(__popc(same)));
#else
  atomic_add(counters[place], 1u);
#endif
}

/// A list that counts past its capacity without writing there, so that the exact need is known and the stage
/// can be run again at that size: nothing is ever dropped.
template <class T>
struct AppendList {
  Span<T> items;
  uint64_t* count = nullptr;
  bool ends_full = false;  ///< true: whoever pushes stops as soon as the list is full

  /// Whether there is use in pushing more: no longer once the list is_overfull().
  COLLIDED_HD bool push(const T& value) const {
    const uint64_t slot = claim_slot(*count);
    if (slot < items.size()) items[slot] = value;
    return slot < most_in_vain();
  }
  /// For threads that have several values each.
  COLLIDED_HD void push_all(const T* values, uint64_t n) const {
    if (n == 0) return;
    const uint64_t first = atomic_add(*count, n);
    for (uint64_t k = 0; k < n && first + k < items.size(); ++k) items[first + k] = values[k];
  }
  /// If more is asked for, it is better to enlarge the list before the rest is counted: what is found in vain stays
  /// below what there has to be room for.
  COLLIDED_HD uint64_t most_in_vain() const {
    if (ends_full) return items.size();
    constexpr uint64_t kAlways = 1u << 22;
    const uint64_t most = 4 * items.size();
    return most < kAlways ? kAlways : most;
  }
  COLLIDED_HD bool is_overfull() const { return atomic_read(*count) > most_in_vain(); }
};

}  // namespace collided
