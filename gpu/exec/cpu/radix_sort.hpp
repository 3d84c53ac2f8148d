#pragma once
// A stable radix sort on CPU cores, least digit first.

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "gpu/exec/cpu/cpu_loops.hpp"
#include "gpu/exec/sort_arrays.hpp"

namespace collided {

/// Passes over items, each of which puts them in order by a digit of theirs and leaves those with the same as they are.
class RadixPasses {
 public:
  static constexpr int kDigitBits = 8;
  RadixPasses(CpuLoops& loops, uint64_t size) : loops_(loops), size_(size), counts_((size + kBlock - 1) / kBlock) {}

  /// By bits [shift, shift + bits) of key(i), up to kDigitBits: move(i, to) for each item.
  template <class Key, class Move>
  void pass(int shift, int bits, const Key& key, const Move& move) {
    const uint64_t mask = (1u << bits) - 1u;
    for_each_block([&](Counts& counts, uint64_t begin, uint64_t end) {
      counts.fill(0);
      for (uint64_t i = begin; i < end; ++i) ++counts[key(i) >> shift & mask];
    });
    uint64_t place = 0;
    for (size_t d = 0; d < Counts{}.size(); ++d)
      for (Counts& counts : counts_) place += std::exchange(counts[d], place);
    for_each_block([&](Counts& places, uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) move(i, places[key(i) >> shift & mask]++);
    });
  }

 private:
  static constexpr uint64_t kBlock = 1u << 15;
  using Counts = std::array<uint64_t, 1u << kDigitBits>;

  template <class Use>
  void for_each_block(const Use& use) {
    loops_.for_each(counts_.size(), 1, [&](uint64_t block) {
      use(counts_[block], block * kBlock, std::min(size_, (block + 1) * kBlock));
    });
  }

  CpuLoops& loops_;
  const uint64_t size_;
  std::vector<Counts> counts_;  ///< of each block; then the places of its items
};

class RadixSort {
 public:
  RadixSort(CpuLoops& loops, const SortArrays& arrays) : passes_(loops, arrays.keys.size()), arrays_(arrays) {}

  /// By the lowest `bits` of the keys; 0 if the result is in `keys`, 1 if it is in `other_keys`.
  int run(int bits) {
    int sorted = 0;
    for (int shift = 0; shift < bits; shift += RadixPasses::kDigitBits) {
      pass(shift, std::min(bits - shift, RadixPasses::kDigitBits));
      std::swap(arrays_.keys, arrays_.other_keys);
      std::swap(arrays_.values, arrays_.other_values);
      sorted ^= 1;
    }
    return sorted;
  }

 private:
  void pass(int shift, int bits) {
    // Copies: what is written in the loop might else be what it reads.
    const SortArrays arrays = arrays_;
    passes_.pass(
        shift, bits, [arrays](uint64_t i) { return arrays.keys[i]; },
        [arrays](uint64_t i, uint64_t to) {
          arrays.other_keys[to] = arrays.keys[i];
          if (!arrays.values.empty()) arrays.other_values[to] = arrays.values[i];
        });
  }

  RadixPasses passes_;
  SortArrays arrays_;
};

/// Keys of any bits, however many of them are alike, in ascending order: their places are sorted, which
/// takes longer than to sort the keys (KeyOrder), but never long without a look whether the frame goes on.
template <class Write>
class PlaceOrder {
 public:
  PlaceOrder(CpuLoops& loops, const KeyArrays<Write>& arrays)
      : loops_(loops),
        arrays_(arrays),
        from_(reinterpret_cast<uint32_t*>(arrays.scratch.data)),
        to_(from_ + arrays.keys.size()) {}

  /// `all`: the bits that any key has.
  void run(uint64_t all) {
    const uint64_t n = arrays_.keys.size();
    loops_.for_each(n, kGrain, [from = from_](uint64_t i) { from[i] = static_cast<uint32_t>(i); });
    RadixPasses passes(loops_, n);
    for (int shift = 0; shift < 64; shift += RadixPasses::kDigitBits) {
      if ((all >> shift & ((1u << RadixPasses::kDigitBits) - 1u)) == 0) continue;
      passes.pass(
          shift, RadixPasses::kDigitBits,
          [keys = arrays_.keys.data, from = from_](uint64_t i) { return keys[from[i]]; },
          [from = from_, places = to_](uint64_t i, uint64_t to) { places[to] = from[i]; });
      std::swap(from_, to_);
    }
    loops_.for_each(n, kGrain,
                    [arrays = arrays_, from = from_](uint64_t i) { arrays.write(i, arrays.keys[from[i]], from[i]); });
  }

 private:
  static constexpr uint64_t kGrain = 1u << 15;

  CpuLoops& loops_;
  const KeyArrays<Write> arrays_;
  uint32_t *from_, *to_;
};

}  // namespace collided
