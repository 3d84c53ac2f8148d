#pragma once
// Section 3.3, first step: the cell-triangle pairs, grouped by leaf.
// Deviation: each leaf's place is known from the counts, so the pairs are placed at once; no radix sort.

#include "gpu/engines/octree/refine.hpp"
#include "gpu/engines/octree/top_down.hpp"

namespace collided {

/// Puts triangles into leaves.
struct Registration {
  Tree tree;
  Span<uint32_t> cursor;  ///< next place of each leaf
  Span<uint32_t> registered;

  /// A cell's leaf, if it is one and has a place.
  COLLIDED_HD uint32_t look(uint32_t cell) const { return tree.type[cell]; }
  COLLIDED_HD uint32_t find(uint32_t cell, uint32_t type) const { return type == kLeaf ? tree.slot[cell] : kNoLeaf; }
  COLLIDED_HD void put(uint32_t triangle, uint32_t leaf) const { registered[count_up(cursor, leaf)] = triangle; }
};

/// Into the leaves among the cells that triangles cover: those of the dense levels (of triangles that cover few, or
/// many), or those of the bricks of a round.
template <class Cells>
struct RegisterTriangles {
  using Item = typename Cells::Item;
  static constexpr bool kWalks = false;
  Registration registration;
  Cells cells;

  COLLIDED_HD Item item(uint64_t i) const { return cells(i); }
  COLLIDED_HD uint32_t look(uint32_t cell) const { return registration.look(cell); }
  COLLIDED_HD uint32_t find(uint32_t cell, uint32_t type) const { return registration.find(cell, type); }
  COLLIDED_HD void act(const Item& item, uint32_t leaf) const { registration.put(item.triangle, leaf); }
};

}  // namespace collided
