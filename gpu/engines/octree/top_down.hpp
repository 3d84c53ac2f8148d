#pragma once
// Section 3.1, second of the two stages: the highest leaf of each branch is the real one.
// Deviation: instead of passing ids down level by level, each cell looks up its ancestors. Leaves get their places as
// they come, by a group at a time, in no particular order: no scan over all cells. A leaf of one triangle has nothing
// to test and gets no place; nor does, in a part of a scene, one whose pairs are another part's.

#include "gpu/base/share.hpp"
#include "gpu/base/tiles.hpp"
#include "gpu/engines/octree/bottom_up.hpp"

namespace collided {

/// Whether a leaf of the cut has no leaf above it.
COLLIDED_HD inline bool is_real_leaf(const Tree& tree, uint32_t cell) {
  while (cell >= tree.dense_cells) {
    const uint32_t brick = tree.brick_of(cell), number = (cell - tree.dense_cells) % kBrickCells + 1;
    cell = number < 9 ? tree.bricks[brick].parent : tree.brick_cell(brick, (number - 1) >> 3);
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
  static constexpr uint32_t kMaxCells = kCellsOfGroup < kBrickCells ? kBrickCells : kCellsOfGroup;
  static constexpr uint32_t kManyRows = 3;  ///< of tiles: a leaf whose items several threads write
  struct Shared {
    uint64_t sums[LeafSum::kCount];    ///< of the group
    uint64_t before[LeafSum::kCount];  ///< of the groups that claimed their places before
    // Registrations by level, in halves of 16 bits: shared memory adds numbers of 32 bits at once, longer ones by
    // trying.
    uint32_t level_low[kMaxLevel + 2], level_high[kMaxLevel + 2];
    // Of the group alone. Numbers that do not fit 32 bits are more than any list takes, so that nothing is written.
    uint32_t leaves, registrations, items, long_leaves;
    uint32_t registration[kMaxCells], item[kMaxCells];  ///< of each leaf
    uint32_t long_leaf[kMaxCells];                      ///< numbers of leaves with many rows
    uint32_t members[kMaxCells];                        ///< of each leaf
  };
  struct Place {
    int level;
    Coords coords;
  };

  Tree tree;
  Span<Leaf> leaves;
  Span<uint32_t> cursor;           ///< of each leaf: its next place
  uint64_t registration_capacity;  ///< below 2^32
  Span<PairItem> items;
  LeafTotals* totals;
  const Share* share = nullptr;  ///< of a part of a scene

  /// index_of(k) is the cell's index, place_of(k) its place, k < count <= kMaxCells.
  template <class IndexOf, class PlaceOf>
  COLLIDED_HD void run(uint32_t count, const Group& group, Shared& shared, const IndexOf& index_of,
                       const PlaceOf& place_of) const {
    clear(group, shared);
    group.sync();
    Sums mine{};
    for (uint32_t k = group.rank; k < count; k += group.size) number_leaf(index_of(k), k, place_of, shared, mine);
    if (!group.any(mine[LeafSum::kLeaves] > 0))
      return add_all((*totals)[LeafSum::kCells], mine[LeafSum::kCells]);  // most groups hold nothing
    for (uint32_t k = 0; k < LeafSum::kCount; ++k) add_all(shared.sums[k], mine[k]);
    group.sync();
    claim(group, shared);
    group.sync();
    if (fits_in_32_bits(shared))
      for (uint32_t k = group.rank; k < count; k += group.size) write_leaf(index_of(k), k, place_of, shared);
    else
      for (uint32_t k = group.rank; k < count; k += group.size) drop_leaf(index_of(k));
    group.sync();
    write_items_of_long_leaves(group, shared);
    group.sync();
  }

 private:
  static constexpr uint32_t kCrowdedLeaf = 64;
  using Sums = uint64_t[LeafSum::kCount];  ///< of one thread

  COLLIDED_HD static void clear(const Group& group, Shared& shared) {
    for (uint32_t k = group.rank; k < LeafSum::kCount; k += group.size) shared.sums[k] = 0;
    for (uint32_t k = group.rank; k < kMaxLevel + 2; k += group.size) shared.level_low[k] = shared.level_high[k] = 0;
    if (group.rank == 0) shared.leaves = shared.registrations = shared.items = shared.long_leaves = 0;
  }

  /// Numbers the leaf within the group.
  template <class PlaceOf>
  COLLIDED_HD void number_leaf(uint32_t cell, uint32_t k, const PlaceOf& place_of, Shared& shared, Sums& mine) const {
    const uint32_t n = tree.counts[cell];
    if (n == 0) return;
    ++mine[LeafSum::kCells];
    if (tree.type[cell] != kLeaf) return;
    tree.slot[cell] = kNoLeaf;
    if (n < 2 || is_others(place_of(k)) || !is_real_leaf(tree, cell)) return;
    const uint64_t tests = tests_of(n), item_count = items_of(n);
    mine[LeafSum::kLeaves] += 1;
    mine[LeafSum::kRegistrations] += n;
    mine[LeafSum::kItems] += item_count;
    mine[LeafSum::kTests] += tests;
    const int level = place_of(k).level;
    // Without bricks a crowd may be a leaf above the lowest level, for in one cell after the other it is the same
    // crowd.
    const bool at_the_bottom = tree.rounds == 0 || level == tree.grid->base + kBrickLevels * tree.rounds;
    if (at_the_bottom && n >= kCrowdedLeaf) mine[LeafSum::kCrowdedTests] += tests;
    const uint32_t number = atomic_add(shared.leaves, 1u);
    shared.members[number] = n;
    shared.registration[number] = atomic_add(shared.registrations, n);
    shared.item[number] = atomic_add(shared.items, static_cast<uint32_t>(item_count));
    const int booked = cell < tree.dense_cells ? level : kMaxLevel + 1;
    atomic_add(shared.level_low[booked], n & 0xFFFFu);
    atomic_add(shared.level_high[booked], n >> 16);
    tree.slot[cell] = number;
  }

  /// Whether all pairs of a leaf are another part's.
  COLLIDED_HD bool is_others(const Place& place) const {
    return share != nullptr && share->holds_cells(*tree.grid, place.level) &&
           !share->has_cell(place.coords, place.level);
  }

  /// Claims the places of the group's leaves.
  COLLIDED_HD void claim(const Group& group, Shared& shared) const {
    for (uint32_t k = group.rank; k < kMaxLevel + 2; k += group.size) {
      const uint64_t registrations = (uint64_t{shared.level_high[k]} << 16) + shared.level_low[k];
      if (registrations != 0) atomic_add(totals->level_registrations[k], registrations);
    }
    for (uint32_t k = group.rank; k < LeafSum::kCount; k += group.size)
      if (shared.sums[k] != 0) shared.before[k] = atomic_add((*totals)[k], shared.sums[k]);
  }
  COLLIDED_HD static bool fits_in_32_bits(const Shared& shared) {
    return shared.sums[LeafSum::kRegistrations] < ~0u && shared.sums[LeafSum::kItems] < ~0u;
  }

  COLLIDED_HD bool has_place(uint32_t cell) const {
    return tree.counts[cell] >= 2 && tree.type[cell] == kLeaf && tree.slot[cell] != kNoLeaf;
  }
  COLLIDED_HD void drop_leaf(uint32_t cell) const {
    if (has_place(cell)) tree.slot[cell] = kNoLeaf;
  }
  template <class PlaceOf>
  COLLIDED_HD void write_leaf(uint32_t cell, uint32_t k, const PlaceOf& place_of, Shared& shared) const {
    if (!has_place(cell)) return;
    const Place place = place_of(k);
    const uint32_t n = tree.counts[cell], number = tree.slot[cell];
    const uint64_t leaf = shared.before[LeafSum::kLeaves] + number;
    const uint64_t offset = shared.before[LeafSum::kRegistrations] + shared.registration[number];
    const bool fits = leaf < leaves.size() && offset + n <= registration_capacity;
    tree.slot[cell] = fits ? static_cast<uint32_t>(leaf) : kNoLeaf;
    if (!fits) return;
    leaves[leaf] = {place.coords, place.level, n, offset};
    cursor[leaf] = static_cast<uint32_t>(offset);
    if (tiles_of(n) >= kManyRows)
      shared.long_leaf[atomic_add(shared.long_leaves, 1u)] = number;
    else
      for (uint32_t row = 0; row < tiles_of(n); ++row) write_items(number, row, shared);
  }
  COLLIDED_HD void write_items_of_long_leaves(const Group& group, const Shared& shared) const {
    // Row by row through all of them, a row for each thread in turn.
    uint32_t row = group.rank;
    for (uint32_t i = 0; i < shared.long_leaves; ++i) {
      const uint32_t number = shared.long_leaf[i], rows = tiles_of(shared.members[number]);
      for (; row < rows; row += group.size) write_items(number, row, shared);
      row -= rows;
    }
  }
  COLLIDED_HD void write_items(uint32_t number, uint32_t row, const Shared& shared) const {
    const uint64_t first = shared.before[LeafSum::kItems] + shared.item[number];
    const uint32_t leaf = static_cast<uint32_t>(shared.before[LeafSum::kLeaves]) + number;
    for_each_item_of_row(leaf, shared.members[number], row, [&](uint64_t k, const PairItem& item) {
      if (first + k < items.size()) items[first + k] = item;
    });
  }
};

/// Leaves of the dense levels; one item for each kMaxCells cells.
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
        kBrickCells, group, shared, [&](uint32_t k) { return place.tree.brick_cell(brick, k + 1); },
        [&](uint32_t k) {
          const int depth = level_of(k + 1);
          const Coords below = morton_coords(k + 1 - level_offset(depth));
          const Coords first{root.cell.x << depth, root.cell.y << depth, root.cell.z << depth};
          return PlaceLeaves::Place{root.level + depth, {first.x + below.x, first.y + below.y, first.z + below.z}};
        });
  }
};

}  // namespace collided
