#pragma once
// Keys in ascending order on CPU cores, stably: dealt to buckets by their highest bits, then each bucket, which fits a
// cache, sorted by the others, lowest digit first. A bucket that is too large is dealt again, by all threads.

#include <algorithm>
#include <array>
#include <bit>
#include <utility>
#include <vector>

#include "gpu/exec/cpu/cpu_loops.hpp"
#include "gpu/exec/sort_arrays.hpp"

namespace collided {

/// What is sorted: a key of two 32-bit halves without the bits that no key has, then its place among the keys if there
/// is data. What does not fit 64 bits is cut off at the top: a bucket's items have the same there.
struct PackedKeys {
  int low_bits, id_bits, place_bits;  ///< id_bits: of both halves, at least one

  /// `all`: the bits that any key has.
  PackedKeys(uint64_t all, uint64_t count, bool has_data)
      : low_bits(std::bit_width(all & 0xffffffffu)),
        id_bits(std::max<int>(low_bits + std::bit_width(all >> 32), 1)),
        place_bits(has_data ? std::bit_width(count) : 0) {}

  int bits() const { return id_bits + place_bits; }
  uint64_t id(uint64_t key) const { return key >> 32 << low_bits | (key & 0xffffffffu); }
  uint64_t key(uint64_t id) const { return id >> low_bits << 32 | (id & mask(low_bits)); }
  uint64_t pack(uint64_t id, uint64_t place) const { return id << place_bits | place; }
  uint64_t place(uint64_t packed) const { return packed & mask(place_bits); }

  static uint64_t mask(int bits) { return (uint64_t{1} << bits) - 1; }
};

/// Sorts the keys of some arrays, once.
template <class Write>
class RadixSort {
 public:
  RadixSort(CpuLoops& loops, const KeyArrays<Write>& arrays)
      : loops_(loops),
        arrays_(arrays),
        packed_(bits_of_all(), arrays.keys.size(), arrays.write.has_data()),
        has_data_(arrays.write.has_data()) {}

  void run() {
    const Range all{0, arrays_.keys.size(), packed_.bits(), 0};
    const int bucket_bits = std::max(bucket_bits_of(all), packed_.bits() - 64);
    // Copies: what is written in the loop might else be what it reads.
    const auto dealt = [keys = arrays_.keys.data, packed = packed_, has_data = has_data_,
                        shift = packed_.id_bits - bucket_bits](uint64_t i) {
      const uint64_t id = packed.id(keys[i]);
      return Dealt{id >> shift, packed.pack(id, has_data ? i : 0)};
    };
    sort_buckets(all, bucket_bits, deal(all, bucket_bits, dealt, arrays_.scratch.data),
                 {arrays_.scratch.data, arrays_.other.data});
  }

 private:
  static constexpr uint64_t kBucket = 4096;  ///< keys, or so
  static constexpr int kMaxBucketBits = 11, kMaxDigitBits = 9;
  static constexpr uint64_t kBlock = 1u << 18;  ///< keys that are dealt at a time
  static constexpr uint64_t kFew = 48;
  static constexpr uint64_t kMaxInBucket = 1u << 17;  ///< what one thread sorts without a look at the clock

  /// Items that differ in their lowest `bits` alone. Their ids are `high` above.
  struct Range {
    uint64_t begin, size;
    int bits;
    uint64_t high;
  };
  struct Dealt {
    uint64_t bucket, item;
  };
  /// Where items are, and room for as many.
  struct Items {
    uint64_t *from, *to;
  };

  uint64_t bits_of_all() const {
    return loops_.reduce(
        arrays_.keys.size(), kBlock, [keys = arrays_.keys](uint64_t i) { return keys[i]; }, uint64_t{0},
        [](uint64_t a, uint64_t b) { return a | b; });
  }
  int id_bits_of(const Range& range) const { return range.bits - packed_.place_bits; }
  /// At least one, so that no number is shifted by 64 bits.
  int bucket_bits_of(const Range& range) const {
    return std::clamp<int>(std::bit_width(range.size / kBucket), 1, std::min(kMaxBucketBits, id_bits_of(range)));
  }

  /// Puts dealt(i) for the range's items where it belongs; returns where each bucket ends.
  template <class DealtOf>
  std::vector<uint64_t> deal(const Range& range, int bucket_bits, const DealtOf& dealt, uint64_t* to) {
    const uint64_t buckets = uint64_t{1} << bucket_bits, blocks = (range.size + kBlock - 1) / kBlock;
    std::vector<uint64_t> places(blocks * buckets), ends(buckets);
    const auto for_each_item = [&](const auto& use) {
      loops_.for_each(blocks, 1, [&](uint64_t block) {
        const uint64_t end = range.begin + std::min(range.size, (block + 1) * kBlock);
        uint64_t* place = places.data() + block * buckets;
        for (uint64_t i = range.begin + block * kBlock; i < end; ++i) use(place, dealt(i));
      });
    };
    for_each_item([](uint64_t* count, const Dealt& item) { ++count[item.bucket]; });
    uint64_t begin = range.begin;
    for (uint64_t bucket = 0; bucket < buckets; ++bucket) {
      for (uint64_t block = 0; block < blocks; ++block) begin += std::exchange(places[block * buckets + bucket], begin);
      ends[bucket] = begin;
    }
    for_each_item([to](uint64_t* place, const Dealt& item) { to[place[item.bucket]++] = item.item; });
    return ends;
  }

  /// Sorts what the range was dealt to.
  void sort_buckets(const Range& range, int bucket_bits, const std::vector<uint64_t>& ends, const Items& items) {
    const auto bucket = [&](uint64_t i) {
      const uint64_t begin = i == 0 ? range.begin : ends[i - 1];
      return Range{begin, ends[i] - begin, range.bits - bucket_bits, range.high << bucket_bits | i};
    };
    loops_.for_each(ends.size(), 4, [&](uint64_t i) {
      if (const Range small = bucket(i); small.size <= kMaxInBucket) sort_in_cache(small, items);
    });
    for (uint64_t i = 0; i < ends.size(); ++i)
      if (const Range large = bucket(i); large.size > kMaxInBucket) sort_large(large, items);
  }

  void sort_large(const Range& range, const Items& items) {
    if (id_bits_of(range) == 0)  // all alike
      return loops_.for_each(range.size, kBlock, [&](uint64_t i) { write(range, items.from, i, i + 1); });
    const int bucket_bits = bucket_bits_of(range);
    const auto dealt = [from = items.from, shift = range.bits - bucket_bits,
                        mask = PackedKeys::mask(bucket_bits)](uint64_t i) {
      return Dealt{from[i] >> shift & mask, from[i]};
    };
    sort_buckets(range, bucket_bits, deal(range, bucket_bits, dealt, items.to), {items.to, items.from});
  }

  void sort_in_cache(const Range& range, const Items& items) const {
    uint64_t *from = items.from + range.begin, *to = items.to + range.begin;
    if (range.size <= kFew) {
      std::sort(from, from + range.size);
    } else {
      const int bits = id_bits_of(range), passes = (bits + kMaxDigitBits - 1) / kMaxDigitBits;
      const auto digit = [&](int pass) {
        const int first = bits * pass / passes, last = bits * (pass + 1) / passes;
        return Digit{packed_.place_bits + first, PackedKeys::mask(last - first)};
      };
      Places places{}, next{};
      for (uint64_t i = 0; passes > 0 && i < range.size; ++i) ++places[digit(0).of(from[i])];
      for (int pass = 0; pass < passes; ++pass, std::swap(from, to), places = next, next.fill(0))
        sort_by_digit(from, to, range.size, digit(pass), places, digit(pass + 1 < passes ? pass + 1 : pass), next);
    }
    write(range, from - range.begin, 0, range.size);
  }

  struct Digit {
    int shift;
    uint64_t mask;

    uint64_t of(uint64_t item) const { return item >> shift & mask; }
  };
  using Places = std::array<uint32_t, 1u << kMaxDigitBits>;
  /// `counts`: of the digit; those of the next one are made on the way.
  static void sort_by_digit(const uint64_t* from, uint64_t* to, uint64_t n, Digit digit, Places& counts, Digit next,
                            Places& next_counts) {
    uint32_t place = 0;
    for (uint32_t& count : counts) place += std::exchange(count, place);
    for (uint64_t i = 0; i < n; ++i) {
      const uint64_t item = from[i];
      ++next_counts[next.of(item)];
      to[counts[digit.of(item)]++] = item;
    }
  }

  /// The range's items [first, end), which are in order.
  void write(const Range& range, const uint64_t* items, uint64_t first, uint64_t end) const {
    const int id_bits = id_bits_of(range);
    const uint64_t high = range.high << id_bits, low = PackedKeys::mask(id_bits);
    // Copies: what is written in the loop might else be what it reads.
    const PackedKeys packed = packed_;
    const Write write = arrays_.write;
    for (uint64_t i = range.begin + first; i < range.begin + end; ++i) {
      const uint64_t item = items[i];
      write(i, packed.key(high | (item >> packed.place_bits & low)), packed.place(item));
    }
  }

  CpuLoops& loops_;
  const KeyArrays<Write> arrays_;
  const PackedKeys packed_;
  const bool has_data_;
};

}  // namespace collided
