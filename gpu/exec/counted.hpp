#pragma once
// Lengths that only the backend knows while a step runs, and threads that work on one item together.

#include "gpu/exec/atomic.hpp"

namespace collided {

/// A length in the backend's memory, cut off at `most`: a list may have been asked to hold more than its capacity.
struct Counted {
  const uint64_t* counter = nullptr;  ///< null: exactly `most`
  uint64_t most = 0;
  uint64_t in_vain = ~uint64_t{0};  ///< beyond this the step has to run again first: then nothing

  COLLIDED_HD uint64_t size() const {
    if (counter == nullptr) return most;
    if (*counter > in_vain) return 0;
    return *counter > most ? most : *counter;
  }
};

/// A part of an item (for_each_part) that there is nothing to do for.
constexpr uint32_t kNothing = ~0u;

/// What there is to do for a part: find() goes on from what look() read. They are two, so that a GPU's thread can look
/// at several parts at once and then wait for the memory only once more.
template <class F>
COLLIDED_HD uint32_t found_in(const F& f, uint32_t part) {
  return f.find(part, f.look(part));
}

/// For groups that share nothing.
struct Nothing {};

/// The threads that work on one item: a block of a GPU, or one thread of a CPU.
/// A functor for them has a type Shared, memory of the group, and kGroupSize, threads on a GPU.
struct Group {
  uint32_t rank, size;

  COLLIDED_HD void sync() const {
#ifdef __CUDA_ARCH__
    __syncthreads();
#endif
  }
  /// Copies, the threads together, 16 bytes each at a time.
  template <class T>
  COLLIDED_HD void copy(T* to, const T* from, uint32_t count) const {
    struct alignas(16) Chunk {
      uint32_t word[4];
    };
    static_assert(sizeof(T) % sizeof(Chunk) == 0 && alignof(T) >= alignof(Chunk));
#ifdef __CUDA_ARCH__
    const uint32_t chunks = count * static_cast<uint32_t>(sizeof(T) / sizeof(Chunk));
    for (uint32_t k = rank; k < chunks; k += size)
      reinterpret_cast<Chunk*>(to)[k] = reinterpret_cast<const Chunk*>(from)[k];
#else
    for (uint32_t k = rank; k < count; k += size) to[k] = from[k];
#endif
  }
  /// Whether a condition holds for any thread of the group, each of which must call; synchronises.
  COLLIDED_HD bool any(bool condition) const {
#ifdef __CUDA_ARCH__
    if (size > 1) return __syncthreads_or(condition) != 0;
#endif
    return condition;
  }
  /// Returns the largest value of all threads, each of which must call. The group is one thread, or a warp.
  COLLIDED_HD double most(double value) const {
#ifdef __CUDA_ARCH__
    if (size > 1)
      for (int offset = 16; offset > 0; offset /= 2) value = fmax(value, __shfl_xor_sync(~0u, value, offset));
#endif
    return value;
  }
  /// Returns the least one, likewise.
  COLLIDED_HD uint32_t least(uint32_t value) const {
#ifdef __CUDA_ARCH__
    if (size > 1)
      for (int offset = 16; offset > 0; offset /= 2) value = min(value, __shfl_xor_sync(~0u, value, offset));
#endif
    return value;
  }
};

/// Calls f(k, team) for a group's share of `count` items, each of which takes long. The group is one thread, or a warp.
/// If items are few, the group works on item i as a team. Otherwise each of its threads takes an item of its own.
template <class F>
COLLIDED_HD void share_few(uint64_t i, const Group& group, uint64_t count, const F& f) {
  constexpr uint64_t kFew = 4096;
  if (count <= kFew) return f(i, group);
  const uint64_t k = i * group.size + group.rank;
  if (k < count) f(k, Group{0, 1});
}

/// An item of many parts for a group, whose threads share them (for_each_of_many_parts).
template <class F>
struct PartsOfItem {
  using Shared = Nothing;
  static constexpr uint32_t kGroupSize = 128;
  F f;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Nothing&) const {
    const typename F::Item item = f.item(i);
    constexpr uint32_t kAtOnce = 4;  // so that they wait for the memory together
    for (uint32_t first = group.rank; first < item.parts; first += kAtOnce * group.size) {
      const auto is_part = [&](uint32_t j) { return first + j * group.size < item.parts; };
      uint32_t part[kAtOnce], seen[kAtOnce], found[kAtOnce];
      for (uint32_t j = 0; j < kAtOnce; ++j) part[j] = is_part(j) ? item.part(first + j * group.size) : 0;
      for (uint32_t j = 0; j < kAtOnce; ++j) seen[j] = is_part(j) ? f.look(part[j]) : 0;
      for (uint32_t j = 0; j < kAtOnce; ++j) found[j] = is_part(j) ? f.find(part[j], seen[j]) : kNothing;
      for (uint32_t j = 0; j < kAtOnce; ++j)
        if (found[j] != kNothing) f.act(item, found[j]);
    }
  }
};

/// Adds the values of all threads of a group, each of which must call, to a sum in its shared memory.
COLLIDED_HD inline void add_all(uint64_t& sum, uint64_t value) {
#ifdef __CUDA_ARCH__
  if (!__any_sync(~0u, value != 0)) return;
  for (int offset = 16; offset > 0; offset /= 2) value += __shfl_xor_sync(~0u, value, offset);
  if ((threadIdx.x & 31u) != 0 || value == 0) return;
#endif
  atomic_add(sum, value);
}

/// For reductions that nothing follows.
struct NothingMore {
  COLLIDED_HD void operator()(uint64_t) const {}
};

}  // namespace collided
