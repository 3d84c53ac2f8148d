#pragma once
// Very many contacts in canonical order by the backend's radix sort: a few passes over all of them, where counting
// first ids would scatter each. The length of the sort is part of a step's plan; what the list does not fill is sorted
// to the end.

#include <bit>

#include "gpu/base/keys.hpp"
#include "gpu/base/vec3.hpp"
#include "gpu/contacts/unordered.hpp"
#include "gpu/exec/buffer.hpp"
#include "gpu/exec/concepts.hpp"
#include "gpu/exec/sort_arrays.hpp"

namespace collided {

/// How keys are packed into the bits that they need: each digit more is a pass more.
struct KeyPacking {
  uint32_t first_ids;  ///< their number; the last key of all is theirs
  int second_bits;

  static KeyPacking of(uint64_t first_ids, uint64_t second_ids) {
    return {static_cast<uint32_t>(first_ids), static_cast<int>(std::bit_width(second_ids))};
  }
  int bits() const { return second_bits + static_cast<int>(std::bit_width(first_ids)); }

  COLLIDED_HD uint64_t pack(uint64_t key) const { return uint64_t{first_id(key)} << second_bits | second_id(key); }
  COLLIDED_HD uint64_t unpack(uint64_t packed) const {
    return pack_ids(static_cast<uint32_t>(packed >> second_bits),
                    static_cast<uint32_t>(packed & ((uint64_t{1} << second_bits) - 1)));
  }
  /// Above all keys.
  COLLIDED_HD uint64_t last() const { return uint64_t{first_ids} << second_bits; }
};

struct PackKeys {
  Counted count;
  Span<const uint64_t> keys;
  KeyPacking packing;
  Span<uint64_t> packed;
  Span<uint32_t> places;  ///< may be empty

  COLLIDED_HD void operator()(uint64_t i) const {
    packed[i] = i < count.size() ? packing.pack(keys[i]) : packing.last();
    if (!places.empty()) places[i] = static_cast<uint32_t>(i);
  }
};

template <class Write>
struct WriteSorted {
  Span<const uint64_t> packed;
  Span<const uint32_t> places;  ///< may be empty
  KeyPacking packing;
  Write write;

  COLLIDED_HD void operator()(uint64_t i) const { write(i, packing.unpack(packed[i]), places.empty() ? i : places[i]); }
};

/// Where the kinds begin, by bisection.
struct FindKindsSorted {
  FeatureRanks ranks;
  KeyPacking packing;
  Span<const uint64_t> packed;
  KindBegins* kinds;

  COLLIDED_HD void operator()(uint64_t kind) const {
    const uint64_t first = packing.pack(pack_ids(ranks.begin[kind], 0));
    uint64_t begin = 0, end = packed.size();
    while (begin < end) {
      const uint64_t middle = begin + (end - begin) / 2;
      if (packed[middle] < first)
        begin = middle + 1;
      else
        end = middle;
    }
    kinds->at[kind] = begin;
  }
};

/// Room for the sort.
template <Executor Exec>
struct RadixBuffers {
  explicit RadixBuffers(Exec& exec)
      : keys{{exec, "order"}, {exec, "order"}}, places{{exec, "order"}, {exec, "order"}} {}

  void reserve(uint64_t length, bool with_places) {
    for (auto& buffer : keys) buffer.allocate(length);
    if (!with_places) return;
    for (auto& buffer : places) buffer.allocate(length);
  }

  Buffer<uint64_t, Exec> keys[2];
  Buffer<uint32_t, Exec> places[2];
};

/// `length`: at least as many as the list has, or the step has to run again.
template <Executor Exec, class Write>
void put_in_order_by_radix(Exec& exec, RadixBuffers<Exec>& buffers, const Unordered<Write>& list, uint64_t length,
                           const KeyPacking& packing) {
  const uint64_t places = list.write.has_data() ? length : 0;
  const SortArrays arrays{buffers.keys[0].span(length), buffers.keys[1].span(length), buffers.places[0].span(places),
                          buffers.places[1].span(places)};
  exec.for_each("pack_keys", length, PackKeys{list.count, list.keys, packing, arrays.keys, arrays.values});
  const int sorted = exec.sort_pairs("sort_contacts", packing.bits(), arrays);
  const Span<const uint64_t> keys = sorted == 0 ? arrays.keys : arrays.other_keys;
  exec.for_each("find_kind_begins", kContactKinds, FindKindsSorted{list.ranks, packing, keys, list.kinds});
  exec.for_each("write_sorted", Counted{list.count.counter, min(list.count.most, length)},
                WriteSorted<Write>{keys, sorted == 0 ? arrays.values : arrays.other_values, packing, list.write});
}

}  // namespace collided
