#pragma once
// Section 3.3, first step: the cell-triangle pairs, grouped by leaf.
// Deviation: each leaf's place is known from the counts, so the pairs are placed at once; no radix sort.

#include "gpu/exec/atomic.hpp"
#include "gpu/math/lattice.hpp"

namespace collided {

/// One unit for each (triangle, covered cell): if the cell is a leaf, the triangle goes into it.
struct RegisterTriangles {
  LevelGrid grid;
  uint32_t first;
  Span<const Box<float>> boxes;
  Span<const uint32_t> slot;
  Span<const uint64_t> offsets;  ///< of each leaf in registered
  Span<uint32_t> cursor;         ///< of each leaf, zeroed by the caller
  Span<uint32_t> registered;

  COLLIDED_HD void operator()(uint64_t triangle, uint64_t rank) const {
    const uint64_t i = grid.covered_cell(boxes[triangle], rank) - first;
    const uint32_t leaf = slot[i];
    if (leaf == slot[i + 1]) return;
    registered[offsets[leaf] + atomic_add(cursor[leaf], 1u)] = static_cast<uint32_t>(triangle);
  }
};

}  // namespace collided
