#pragma once
// Contacts in canonical order, whatever order they were found in: by first id, then by second id.
// The first ids are few, so that they are counted and the contacts placed, as in the octree; the few contacts of one
// first id are then ranked against each other. Where they are many, a group sorts them.

#include "gpu/base/keys.hpp"
#include "gpu/base/vec3.hpp"
#include "gpu/contacts/kinds.hpp"
#include "gpu/contacts/radix_order.hpp"
#include "gpu/contacts/unordered.hpp"
#include "gpu/exec/atomic.hpp"
#include "gpu/exec/buffer.hpp"
#include "gpu/exec/concepts.hpp"
#include "gpu/exec/counted.hpp"
#include "gpu/exec/sort_arrays.hpp"

namespace collided {

/// More entries than this of one first id are sorted by a group.
constexpr uint32_t kManyEntries = 256;

/// place[i] = how many entries with the same first id came before.
struct CountFirstIds {
  Span<const uint64_t> keys;
  Span<uint32_t> counts;  ///< of each first id, zeroed
  Span<uint32_t> place;
  AppendList<uint32_t> crowded;  ///< first ids with many entries

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint32_t first = static_cast<uint32_t>(keys[i] >> 32);
    place[i] = count_up(counts, first);
    if (place[i] == kManyEntries) crowded.push(first);
  }
};

/// An entry while it is sorted: its second id, and where it was found.
struct Entry {
  uint32_t second, index;
};

/// Places the entries by their first ids, and notes where the kinds begin.
struct PlaceEntries {
  Span<const uint64_t> keys;
  Span<const uint32_t> begin;  ///< of each first id
  Span<const uint32_t> place;
  Span<Entry> entries;
  FeatureRanks ranks;
  KindBegins* kinds;  ///< zeroed

  COLLIDED_HD void operator()(uint64_t i) const {
    for (size_t kind = 0; i == 0 && kind < kContactKinds; ++kind) kinds->at[kind] = begin[ranks.begin[kind]];
    const uint64_t key = keys[i];
    entries[begin[key >> 32] + place[i]] = {static_cast<uint32_t>(key), static_cast<uint32_t>(i)};
  }
};

/// Bitonic sort of the entries of one crowded first id; any length.
struct SortCrowded {
  using Shared = Nothing;
  static constexpr uint32_t kGroupSize = 1024;
  Span<const uint32_t> crowded, begin;
  Span<Entry> entries;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Nothing&) const {
    Entry* first = entries.data + begin[crowded[i]];
    const uint64_t n = begin[uint64_t{crowded[i]} + 1] - begin[crowded[i]];
    for (uint64_t width = 2; width / 2 < n; width *= 2) {
      // Each block of `width` is the join of two sorted halves: the second is met in reverse.
      pass(first, n, width, true, group);
      for (uint64_t step = width / 2; step >= 2; step /= 2) pass(first, n, step, false, group);
    }
  }

 private:
  COLLIDED_HD static void pass(Entry* entries, uint64_t n, uint64_t width, bool reverse, const Group& group) {
    const uint64_t half = width / 2;
    for (uint64_t k = group.rank; k < (n + width - 1) / width * half; k += group.size) {
      const uint64_t block = k / half * width, offset = k % half;
      const uint64_t low = block + offset, high = reverse ? block + width - 1 - offset : low + half;
      if (high < n && entries[high].second < entries[low].second) {
        const Entry swapped = entries[low];
        entries[low] = entries[high];
        entries[high] = swapped;
      }
    }
    group.sync();
  }
};

/// Ranks the entries of a first id against each other, and writes them in order.
template <class Write>
struct WriteInOrder {
  Span<const uint64_t> keys;
  Span<const uint32_t> begin;  ///< of each first id
  Span<const Entry> entries;
  Write write;

  COLLIDED_HD void operator()(uint64_t i) const {
    const Entry mine = entries[i];
    const uint64_t key = keys[mine.index], first = key >> 32;
    const uint32_t from = begin[first], to = begin[first + 1];
    uint64_t place = i;
    if (to - from <= kManyEntries) {
      place = from;
      for (uint32_t k = from; k < to; ++k) place += entries[k].second < mine.second ? 1 : 0;
    }
    write(place, key, mine.index);
  }
};

/// How many keys are of earlier kinds, for each kind.
struct CountEarlierKinds {
  FeatureRanks ranks;
  Span<const uint64_t> keys;

  COLLIDED_HD KindBegins operator()(uint64_t i) const {
    const uint32_t rank = first_id(keys[i]);
    KindBegins earlier;
    for (size_t kind = 0; kind < kContactKinds; ++kind) earlier.at[kind] = rank < ranks.begin[kind] ? 1 : 0;
    return earlier;
  }
};
struct AddKinds {
  COLLIDED_HD KindBegins operator()(const KindBegins& a, const KindBegins& b) const {
    KindBegins sum;
    for (size_t kind = 0; kind < kContactKinds; ++kind) sum.at[kind] = a.at[kind] + b.at[kind];
    return sum;
  }
};

/// Contacts that are ordered in one launch, each against all others.
constexpr uint64_t kFewContacts = 512;

template <class Write>
struct RankFew {
  struct Shared {
    uint32_t below;  ///< keys
  };
  static constexpr uint32_t kGroupSize = 64;
  Counted count;
  Span<const uint64_t> keys;
  CountEarlierKinds kinds;
  KindBegins* begins;  ///< zeroed
  Write write;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Shared& shared) const {
    if (group.rank == 0) shared.below = 0;
    group.sync();
    const uint64_t key = keys[i], n = count.size();
    uint32_t below = 0;
    for (uint64_t k = group.rank; k < n; k += group.size) below += keys[k] < key ? 1 : 0;
    atomic_add(shared.below, below);
    group.sync();
    if (group.rank != 0) return;
    const KindBegins earlier = kinds(i);
    for (size_t kind = 0; kind < kContactKinds; ++kind)
      if (earlier.at[kind] != 0) atomic_add(begins->at[kind], earlier.at[kind]);
    write(shared.below, key, i);
  }
};

/// Room to count and place contacts in.
template <Executor Exec>
struct CountingBuffers {
  explicit CountingBuffers(Exec& exec)
      : counts(exec, "order"), place(exec, "order"), crowded(exec, "order"), entries(exec, "order") {}

  /// For lists of up to `capacity` entries with first ids below `first_ids`.
  void reserve(uint64_t first_ids, uint64_t capacity) {
    counts.allocate(first_ids + 1);
    place.allocate(capacity);
    crowded.allocate(capacity / kManyEntries + 1);
    entries.allocate(capacity);
  }

  Buffer<uint32_t, Exec> counts, place, crowded;
  Buffer<Entry, Exec> entries;
};

/// Room for a backend's own sort.
template <Executor Exec>
struct KeyBuffers {
  explicit KeyBuffers(Exec& exec) : scratch(exec, "order"), other(exec, "order") {}

  void reserve(uint64_t, uint64_t capacity) {
    scratch.allocate(capacity);
    other.allocate(capacity);
  }

  Buffer<uint64_t, Exec> scratch, other;
};

/// Of a backend without one, which sorts very many by its radix sort.
template <Executor Exec>
struct CountingOrRadixBuffers {
  explicit CountingOrRadixBuffers(Exec& exec) : counting(exec), radix(exec) {}

  CountingBuffers<Exec> counting;
  RadixBuffers<Exec> radix;
};

template <Executor Exec>
using OrderBuffers = std::conditional_t<SortsKeys<Exec>, KeyBuffers<Exec>, CountingOrRadixBuffers<Exec>>;

/// How a list is put in order, decided before its length is known.
struct OrderPlan {
  bool has_many = true;       ///< there may be more than kFewContacts
  uint64_t radix_length = 0;  ///< that a radix sort has room for; 0: the list is shorter than is worth one

  bool operator==(const OrderPlan&) const = default;
};

/// Ids of a scene's features.
struct IdCounts {
  uint64_t first, second;  ///< first: ranks
};

/// For lists of up to `capacity` contacts, of which all have more than keys or none.
template <Executor Exec>
void reserve_order(OrderBuffers<Exec>& buffers, const OrderPlan& plan, const IdCounts& ids, uint64_t capacity,
                   bool has_data) {
  if constexpr (SortsKeys<Exec>)
    buffers.reserve(ids.first, capacity);
  else if (plan.radix_length > 0)
    buffers.radix.reserve(plan.radix_length, has_data);
  else
    buffers.counting.reserve(ids.first, capacity);
}

/// `crowded` is a zeroed counter.
template <Executor Exec, class Write>
void put_in_order_by_counts(Exec& exec, CountingBuffers<Exec>& buffers, const Unordered<Write>& list,
                            uint64_t* crowded) {
  const Span<uint32_t> counts = buffers.counts.all();
  const Counted crowded_count{crowded, buffers.crowded.capacity()};
  exec.fill_zero(counts.data, counts.size() * sizeof(uint32_t));
  exec.for_each("count_first_ids", list.count,
                CountFirstIds{list.keys, counts, buffers.place.all(), {buffers.crowded.all(), crowded}});
  exec.exclusive_scan("scan_first_ids", counts);
  exec.for_each("place_entries", list.count,
                PlaceEntries{list.keys, counts, buffers.place.all(), buffers.entries.all(), list.ranks, list.kinds});
  exec.for_each_group("sort_crowded", crowded_count, SortCrowded{buffers.crowded.all(), counts, buffers.entries.all()});
  exec.for_each("write_in_order", list.count,
                WriteInOrder<Write>{list.keys, counts, buffers.entries.all(), list.write});
}

/// The length now, read by the backend: a dry run has no memory to read it from.
template <Executor Exec>
uint64_t length_now(const Exec& exec, Counted count) {
  const uint64_t counted = count.counter == nullptr ? 0 : exec.peek(count.counter);
  if (count.counter != nullptr) count.counter = &counted;
  return count.size();
}

/// The same in whatever way is the backend's fastest.
template <Executor Exec, class Write>
void put_in_order(Exec& exec, OrderBuffers<Exec>& buffers, const Unordered<Write>& list, const OrderPlan& plan,
                  const IdCounts& ids, uint64_t* crowded) {
  if constexpr (SortsKeys<Exec>) {
    exec.reduce_into("kind_begins", length_now(exec, list.count), CountEarlierKinds{list.ranks, list.keys},
                     KindBegins{}, AddKinds{}, list.kinds);
    exec.sort_keys("sort_keys", list.count,
                   KeyArrays<Write>{list.keys, buffers.scratch.all(), buffers.other.all(), list.write});
  } else if (plan.radix_length > 0) {
    put_in_order_by_radix(exec, buffers.radix, list, plan.radix_length, KeyPacking::of(ids.first, ids.second));
  } else if (!plan.has_many) {
    const Counted first{list.count.counter, min(list.count.most, kFewContacts)};
    exec.for_each_group(
        "rank_few", first,
        RankFew<Write>{first, list.keys, CountEarlierKinds{list.ranks, list.keys}, list.kinds, list.write});
  } else {
    put_in_order_by_counts(exec, buffers.counting, list, crowded);
  }
}

}  // namespace collided
