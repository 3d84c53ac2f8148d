#pragma once
// Section 3.1, second of the two stages: the highest leaf of each branch is the real one.
// Deviation: instead of passing ids down level by level, each cell looks up its ancestors. Leaves get their places as
// they come, by a group at a time, in no particular order: no scan over all cells. A leaf of one triangle has nothing
// to test and gets no place.

#include "gpu/math/tiles.hpp"
#include "gpu/octree/bottom_up.hpp"

namespace collided {

/// What the leaves need, added up by all groups.
struct LeafTotals {
  uint64_t cells;  ///< with triangles
  uint64_t leaves, registrations, items;
  uint64_t tests;
  uint64_t crowded_tests;                       ///< of crowded leaves at the lowest level, which might be refined
  uint64_t level_registrations[kMaxLevel + 2];  ///< of each dense level, then of all bricks
};

/// Whether a leaf of the cut has no leaf above it.
COLLIDED_HD inline bool is_real_leaf(const Tree& tree, uint32_t cell) {
  while (cell >= kDenseCells) {
    const uint32_t brick = (cell - kDenseCells) / kBrickCells, number = (cell - kDenseCells) % kBrickCells + 1;
    cell = number < 9 ? tree.bricks[brick].parent : brick_cell(brick, (number - 1) >> 3);
    if (tree.type[cell] == kLeaf) return false;
  }
  const uint32_t below_top = level_offset(tree.grid->top + 1);
  while (cell >= below_top) {
    cell = (cell - 1) >> 3;
    if (tree.type[cell] == kLeaf) return false;
  }
  return true;
}

/// Places the leaves among the cells of a group.
struct PlaceLeaves {
  static constexpr uint32_t kMostCells = kCellsOfGroup;
  struct Shared {
    LeafTotals totals;
    uint64_t first_leaf, first_registration, first_item;
    uint64_t registration[kMostCells], item[kMostCells];  ///< of each leaf of the group
  };
  struct Place {
    int level;
    Coords coords;
  };

  Tree tree;
  Span<Leaf> leaves;
  Span<uint32_t> cursor;  ///< of each leaf
  uint64_t registration_capacity;
  Span<PairItem> items;
  LeafTotals* totals;

  /// index_of(k) is the cell's index, place_of(k) its place, k < count <= kMostCells.
  template <class IndexOf, class PlaceOf>
  COLLIDED_HD void run(uint32_t count, const Group& group, Shared& shared, const IndexOf& index_of,
                       const PlaceOf& place_of) const {
    clear(group, shared);
    group.sync();
    for (uint32_t k = group.rank; k < count; k += group.size) number_leaf(index_of(k), place_of(k).level, shared);
    group.sync();
    claim(group, shared);
    group.sync();
    for (uint32_t k = group.rank; k < count; k += group.size) write_leaf(index_of(k), place_of(k), shared);
    group.sync();
  }

 private:
  static constexpr uint32_t kTotals = sizeof(LeafTotals) / sizeof(uint64_t);

  COLLIDED_HD static void clear(const Group& group, Shared& shared) {
    uint64_t* values = &shared.totals.cells;
    for (uint32_t k = group.rank; k < kTotals; k += group.size) values[k] = 0;
  }

  /// Numbers the leaf within the group.
  COLLIDED_HD void number_leaf(uint32_t cell, int level, Shared& shared) const {
    const uint32_t n = tree.counts[cell];
    if (n == 0) return;
    LeafTotals& sum = shared.totals;
    atomic_add(sum.cells, uint64_t{1});
    if (tree.type[cell] != kLeaf) return;
    tree.slot[cell] = kNoLeaf;
    if (n < 2 || !is_real_leaf(tree, cell)) return;
    const uint64_t number = atomic_add(sum.leaves, uint64_t{1});
    shared.registration[number] = atomic_add(sum.registrations, uint64_t{n});
    shared.item[number] = atomic_add(sum.items, items_of(n));
    atomic_add(sum.tests, tests_of(n));
    if (level == tree.grid->base + kBrickLevels * tree.rounds && n >= kCrowdedLeaf)
      atomic_add(sum.crowded_tests, tests_of(n));
    atomic_add(sum.level_registrations[smaller(level, kMaxLevel + 1)], uint64_t{n});
    tree.slot[cell] = static_cast<uint32_t>(number);
  }
  static constexpr uint32_t kCrowdedLeaf = 64;

  /// Claims the places of the group's leaves.
  COLLIDED_HD void claim(const Group& group, Shared& shared) const {
    const uint64_t* values = &shared.totals.cells;
    uint64_t* sums = &totals->cells;
    for (uint32_t k = group.rank; k < kTotals; k += group.size) {
      if (values[k] == 0) continue;
      const uint64_t before = atomic_add(sums[k], values[k]);
      if (k == 1) shared.first_leaf = before;
      if (k == 2) shared.first_registration = before;
      if (k == 3) shared.first_item = before;
    }
  }

  COLLIDED_HD void write_leaf(uint32_t cell, const Place& place, const Shared& shared) const {
    const uint32_t n = tree.counts[cell];
    if (n < 2 || tree.type[cell] != kLeaf || tree.slot[cell] == kNoLeaf) return;
    const uint64_t number = tree.slot[cell];
    const uint64_t leaf = shared.first_leaf + number, offset = shared.first_registration + shared.registration[number];
    const bool fits = leaf < leaves.size() && offset + n <= registration_capacity;
    tree.slot[cell] = fits ? static_cast<uint32_t>(leaf) : kNoLeaf;
    if (!fits) return;
    leaves[leaf] = {place.coords, place.level, n, 0, offset};
    cursor[leaf] = 0;
    const uint64_t first = shared.first_item + shared.item[number];
    for_each_item(static_cast<uint32_t>(leaf), n, [&](uint64_t k, const PairItem& item) {
      if (first + k < items.size()) items[first + k] = item;
    });
  }
};

/// Leaves of the dense levels; one item for each kMostCells cells.
struct PlaceDenseLeaves {
  using Shared = PlaceLeaves::Shared;
  static constexpr uint32_t kGroupSize = 256;
  PlaceLeaves place;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Shared& shared) const {
    const CellSlice slice(*place.tree.grid, i);
    const uint32_t first = slice.first;
    place.run(
        slice.count, group, shared, [&](uint32_t k) { return first + k; },
        [&](uint32_t k) {
          const int level = level_of(first + k);
          return PlaceLeaves::Place{level, morton_coords(first + k - level_offset(level))};
        });
  }
};

/// Leaves of the bricks of one round; one item a brick.
struct PlaceBrickLeaves {
  using Shared = PlaceLeaves::Shared;
  static constexpr uint32_t kGroupSize = 256;
  PlaceLeaves place;
  int round;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Shared& shared) const {
    const uint32_t brick = static_cast<uint32_t>(place.tree.first_brick(round) + i);
    if (brick >= place.tree.bricks.size()) return;
    const Brick root = place.tree.bricks[brick];
    place.run(
        kBrickCells, group, shared, [&](uint32_t k) { return brick_cell(brick, k + 1); },
        [&](uint32_t k) {
          const int depth = level_of(k + 1);
          const Coords below = morton_coords(k + 1 - level_offset(depth));
          const Coords first{root.cell.x << depth, root.cell.y << depth, root.cell.z << depth};
          return PlaceLeaves::Place{root.level + depth, {first.x + below.x, first.y + below.y, first.z + below.z}};
        });
  }
};

}  // namespace collided
