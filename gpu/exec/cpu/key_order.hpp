#pragma once
// Keys in ascending order on CPU cores: dealt to buckets by their highest bits, then each bucket, which fits a cache,
// sorted by the others, lowest digit first. Where buckets would not do, the keys' places are sorted.

#include <algorithm>
#include <array>
#include <bit>
#include <utility>
#include <vector>

#include "gpu/exec/cpu/cpu_loops.hpp"
#include "gpu/exec/cpu/radix_sort.hpp"
#include "gpu/exec/sort_arrays.hpp"

namespace collided {

/// What is sorted: a key without the bits that no key has, then its place among the keys if there is data.
struct PackedKeys {
  int first_bits, second_bits, place_bits;

  /// `all`: the bits that any key has.
  PackedKeys(uint64_t all, uint64_t count, bool has_data)
      : first_bits(std::bit_width(all >> 32)),
        second_bits(std::bit_width(all & 0xffffffffu)),
        place_bits(has_data ? std::bit_width(count) : 0) {}

  /// Whether 64 bits are enough.
  bool fit() const { return bits() <= 63; }
  int bits() const { return first_bits + second_bits + place_bits; }
  uint64_t pack(uint64_t key, uint64_t place) const {
    const uint64_t low = key & 0xffffffffu;
    return ((key >> 32) << second_bits | low) << place_bits | (place_bits == 0 ? 0 : place);
  }
  uint64_t key(uint64_t packed) const {
    const uint64_t ids = packed >> place_bits;
    return ids >> second_bits << 32 | (ids & mask(second_bits));
  }
  uint64_t place(uint64_t packed) const { return packed & mask(place_bits); }

 private:
  static uint64_t mask(int bits) { return (uint64_t{1} << bits) - 1; }
};

/// Puts the keys of some arrays in order, once.
template <class Write>
class KeyOrder {
 public:
  KeyOrder(CpuLoops& loops, const KeyArrays<Write>& arrays)
      : loops_(loops),
        arrays_(arrays),
        all_(bits_of(loops, arrays.keys)),
        packed_(all_, arrays.keys.size(), arrays.write.has_data()),
        bucket_bits_(std::clamp<int>(std::bit_width(arrays.keys.size() / kBucket), 0,
                                     std::min(kMaxBucketBits, packed_.first_bits + packed_.second_bits))) {}

  void run() {
    if (!packed_.fit() || !count_buckets()) return PlaceOrder(loops_, arrays_).run(all_);
    if (bits_within() <= 32)
      run_with(reinterpret_cast<uint32_t*>(arrays_.scratch.data),
               reinterpret_cast<uint32_t*>(arrays_.scratch.data) + arrays_.keys.size());
    else
      run_with(arrays_.scratch.data, arrays_.other.data);
  }

 private:
  static constexpr uint64_t kBucket = 4096;  ///< keys, or so
  static constexpr int kMaxBucketBits = 11, kMaxDigitBits = 9;
  static constexpr uint64_t kBlock = 1u << 18;  ///< keys that are dealt at a time
  static constexpr uint64_t kFew = 48;
  static constexpr uint64_t kMaxInBucket = 1u << 17;  ///< what one thread sorts without a look at the clock

  static uint64_t bits_of(CpuLoops& loops, Span<const uint64_t> keys) {
    return loops.reduce(
        keys.size(), kBlock, [&](uint64_t i) { return keys[i]; }, uint64_t{0},
        [](uint64_t a, uint64_t b) { return a | b; });
  }

  /// By way of two arrays of what buckets hold.
  template <class Item>
  void run_with(Item* dealt, Item* other) {
    deal(dealt);
    loops_.for_each(buckets(), 4, [&](uint64_t i) { sort_bucket(i, dealt, other); });
  }

  uint64_t buckets() const { return uint64_t{1} << bucket_bits_; }
  uint64_t bucket_begin(uint64_t bucket) const { return bucket == 0 ? 0 : ends_[bucket - 1]; }
  /// Bits that tell the keys of a bucket apart.
  int bits_within() const { return packed_.bits() - bucket_bits_; }

  /// use(the place of the key's bucket in the key's block, packed key) for all keys.
  template <class Use>
  void for_each_key(const Use& use) {
    loops_.for_each(blocks(), 1, [&](uint64_t block) {
      // Copies: what is written in the loop might else be what it reads.
      const uint64_t *keys = arrays_.keys.data, end = std::min<uint64_t>(arrays_.keys.size(), (block + 1) * kBlock);
      const PackedKeys packed_keys = packed_;
      const int within = bits_within();
      uint64_t* place = places_.data() + block * buckets();
      for (uint64_t i = block * kBlock; i < end; ++i) {
        const uint64_t packed = packed_keys.pack(keys[i], i);
        use(place[packed >> within], packed);
      }
    });
  }
  uint64_t blocks() const { return (arrays_.keys.size() + kBlock - 1) / kBlock; }

  /// Finds where each bucket begins; false if one of them has too many keys.
  bool count_buckets() {
    places_.assign(blocks() * buckets(), 0);
    for_each_key([](uint64_t& count, uint64_t) { ++count; });
    ends_.resize(buckets());
    uint64_t begin = 0, most = 0;
    for (uint64_t bucket = 0; bucket < buckets(); ++bucket) {
      for (uint64_t block = 0; block < blocks(); ++block)
        begin += std::exchange(places_[block * buckets() + bucket], begin);
      ends_[bucket] = begin;
      most = std::max(most, begin - bucket_begin(bucket));
    }
    return most <= kMaxInBucket;
  }
  /// Buckets hold the keys without their highest bits.
  template <class Item>
  void deal(Item* dealt) {
    for_each_key([dealt](uint64_t& place, uint64_t packed) { dealt[place++] = static_cast<Item>(packed); });
  }

  template <class Item>
  void sort_bucket(uint64_t bucket, Item* dealt, Item* other) const {
    const uint64_t begin = bucket_begin(bucket), n = bucket_begin(bucket + 1) - begin;
    Item *from = dealt + begin, *to = other + begin;
    if (n <= kFew) {
      std::sort(from, from + n);
    } else {
      const int bits = bits_within() - packed_.place_bits;
      const int passes = (bits + kMaxDigitBits - 1) / kMaxDigitBits;
      const auto digit = [&](int pass) {
        const int first = bits * pass / passes, last = bits * (pass + 1) / passes;
        return Digit{packed_.place_bits + first, (uint64_t{1} << (last - first)) - 1};
      };
      Places places{}, next{};
      for (uint64_t i = 0; passes > 0 && i < n; ++i) ++places[digit(0).of(from[i])];
      for (int pass = 0; pass < passes; ++pass, std::swap(from, to), places = next, next.fill(0))
        sort_by_digit(from, to, n, digit(pass), places, digit(pass + 1 < passes ? pass + 1 : pass), next);
    }
    write(from, bucket, begin, n);
  }

  struct Digit {
    int shift;
    uint64_t mask;

    uint64_t of(uint64_t item) const { return item >> shift & mask; }
  };
  using Places = std::array<uint32_t, 1u << kMaxDigitBits>;
  /// `counts`: of the digit; those of the next one are made on the way.
  template <class Item>
  static void sort_by_digit(const Item* from, Item* to, uint64_t n, Digit digit, Places& counts, Digit next,
                            Places& next_counts) {
    uint32_t place = 0;
    for (uint32_t& count : counts) place += std::exchange(count, place);
    for (uint64_t i = 0; i < n; ++i) {
      const Item item = from[i];
      ++next_counts[next.of(item)];
      to[counts[digit.of(item)]++] = item;
    }
  }
  template <class Item>
  void write(const Item* from, uint64_t bucket, uint64_t begin, uint64_t n) const {
    const uint64_t high = bucket << bits_within(), low = (uint64_t{1} << bits_within()) - 1;
    // Copies: what is written in the loop might else be what it reads.
    const PackedKeys packed_keys = packed_;
    const Write write = arrays_.write;
    for (uint64_t i = 0; i < n; ++i) {
      const uint64_t packed = high | (from[i] & low);
      write(begin + i, packed_keys.key(packed), packed_keys.place(packed));
    }
  }

  CpuLoops& loops_;
  KeyArrays<Write> arrays_;
  const uint64_t all_;  ///< bits that any key has
  PackedKeys packed_;
  int bucket_bits_;
  std::vector<uint64_t> places_;  ///< where each block's keys of each bucket go
  std::vector<uint64_t> ends_;    ///< of the buckets
};

}  // namespace collided
