#pragma once
// Section 3.1, second of the two stages: the highest leaf of each branch is the real one.
// Deviation: instead of passing ids down level by level, each cell looks up its at most seven ancestors.

#include "gpu/exec/atomic.hpp"
#include "gpu/octree/bottom_up.hpp"

namespace collided {

/// slot[cell - first] = 1 for a real leaf, else 0; one entry more than cells, for the scan's total.
struct MarkRealLeaves {
  int top;
  uint32_t first;
  Span<const uint8_t> type;
  Span<uint32_t> slot;

  COLLIDED_HD void operator()(uint64_t i) const { slot[i] = i + 1 < slot.size() && is_real_leaf(first + i) ? 1 : 0; }

 private:
  COLLIDED_HD bool is_real_leaf(uint64_t cell) const {
    if (type[cell] != kLeaf) return false;
    while (cell >= level_offset(top + 1)) {
      cell = (cell - 1) >> 3;
      if (type[cell] == kLeaf) return false;
    }
    return true;
  }
};

/// After the scan of slot: writes the leaf's record, its registrations and its units of pair tests.
struct WriteLeaves {
  uint32_t first;
  Span<const uint32_t> slot;
  Span<const uint32_t> counts;
  Span<Leaf> leaves;
  Span<uint64_t> registrations;  ///< one more than leaves
  Span<uint64_t> level_registrations;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (slot[i] == slot[i + 1]) return;
    const uint32_t cell = static_cast<uint32_t>(first + i);
    const int level = level_of(cell);
    leaves[slot[i]] = {morton_coords(cell - level_offset(level)), level, counts[cell]};
    registrations[slot[i]] = counts[cell];
    atomic_add(level_registrations[static_cast<uint64_t>(level)], static_cast<uint64_t>(counts[cell]));
  }
};

struct IsNonEmpty {
  uint32_t first;
  Span<const uint32_t> counts;
  COLLIDED_HD uint64_t operator()(uint64_t i) const { return counts[first + i] != 0 ? 1 : 0; }
};
struct TestsOfLeaf {
  Span<const Leaf> leaves;
  COLLIDED_HD uint64_t operator()(uint64_t i) const { return tests_of(leaves[i].count); }
};
struct Add {
  COLLIDED_HD uint64_t operator()(uint64_t a, uint64_t b) const { return a + b; }
};

}  // namespace collided
