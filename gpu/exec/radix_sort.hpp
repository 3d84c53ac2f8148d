#pragma once
// A stable radix sort on CPU cores, least digit first.

#include <array>
#include <utility>
#include <vector>

#include "gpu/exec/cpu_loops.hpp"
#include "gpu/exec/sort_arrays.hpp"

namespace collided {

class RadixSort {
 public:
  RadixSort(CpuLoops& loops, const SortArrays& arrays) : loops_(loops), arrays_(arrays), counts_(blocks()) {}

  /// By the lowest `bits` of the keys; 0 if the result is in `keys`, 1 if it is in `other_keys`.
  int run(int bits) {
    int sorted = 0;
    for (int shift = 0; shift < bits; shift += kDigitBits) {
      pass(shift, bits - shift < kDigitBits ? bits - shift : kDigitBits);
      std::swap(arrays_.keys, arrays_.other_keys);
      std::swap(arrays_.values, arrays_.other_values);
      sorted ^= 1;
    }
    return sorted;
  }

 private:
  static constexpr int kDigitBits = 8;
  static constexpr uint64_t kBlock = 1u << 15;
  using Counts = std::array<uint64_t, 1u << kDigitBits>;

  uint64_t blocks() const { return (arrays_.keys.size() + kBlock - 1) / kBlock; }
  uint64_t end_of(uint64_t block) const {
    const uint64_t end = (block + 1) * kBlock;
    return end < arrays_.keys.size() ? end : arrays_.keys.size();
  }
  static uint64_t digit(uint64_t key, int shift, int bits) { return key >> shift & ((1u << bits) - 1u); }

  void pass(int shift, int bits) {
    loops_.for_each(blocks(), 1, [&](uint64_t block) {
      Counts& counts = counts_[block];
      counts.fill(0);
      for (uint64_t i = block * kBlock; i < end_of(block); ++i) ++counts[digit(arrays_.keys[i], shift, bits)];
    });
    uint64_t place = 0;
    for (size_t d = 0; d < Counts{}.size(); ++d)
      for (Counts& counts : counts_) place += std::exchange(counts[d], place);
    loops_.for_each(blocks(), 1, [&](uint64_t block) {
      Counts& places = counts_[block];
      for (uint64_t i = block * kBlock; i < end_of(block); ++i) {
        const uint64_t to = places[digit(arrays_.keys[i], shift, bits)]++;
        arrays_.other_keys[to] = arrays_.keys[i];
        arrays_.other_values[to] = arrays_.values[i];
      }
    });
  }

  CpuLoops& loops_;
  SortArrays arrays_;
  std::vector<Counts> counts_;  ///< of each block; then the places of its entries
};

}  // namespace collided
