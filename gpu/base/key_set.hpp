#pragma once
// A set of keys that many threads look up at once: open addressing, with half of the slots or more free. The host fills
// it, once.

#include <vector>

#include "gpu/base/host_device.hpp"

namespace collided {

/// A slot that is free; no key is this number.
constexpr uint64_t kNoKey = ~uint64_t{0};

/// Neighbouring ids must not lie in neighbouring slots (the finalizer of splitmix64).
COLLIDED_HD inline uint64_t mixed_key(uint64_t key) {
  key = (key ^ key >> 30) * 0xbf58476d1ce4e5b9u;
  key = (key ^ key >> 27) * 0x94d049bb133111ebu;
  return key ^ key >> 31;
}

struct KeySet {
  Span<const uint64_t> slots;  ///< a power of two of them; none: the empty set, which takes no look-up

  COLLIDED_HD bool empty() const { return slots.empty(); }
  COLLIDED_HD bool has(uint64_t key) const { return !empty() && slots[slot_of(key)] == key; }
  /// Where the key is, or else the free slot where it would be.
  COLLIDED_HD uint64_t slot_of(uint64_t key) const {
    const uint64_t last = slots.size() - 1;
    uint64_t slot = mixed_key(key) & last;
    while (slots[slot] != key && slots[slot] != kNoKey) slot = (slot + 1) & last;
    return slot;
  }
};

/// Slots for so many keys.
inline uint64_t key_slots(uint64_t keys) {
  uint64_t slots = keys == 0 ? 0 : 2;
  while (slots < 2 * keys) slots *= 2;
  return slots;
}

/// Adds a key to slots that have room for it.
inline void add_key(std::vector<uint64_t>& slots, uint64_t key) {
  slots[KeySet{{slots.data(), slots.size()}}.slot_of(key)] = key;
}

}  // namespace collided
