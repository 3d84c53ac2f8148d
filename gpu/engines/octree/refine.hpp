#pragma once
// Sparse levels below the dense ones, for scenes of mixed scale: crowded cells get bricks, round by round.
// What is refined affects speed alone, so both guards may be rough: a brick is opened only where many triangles are,
// and below a brick only if its triangles did not spread over too many of its cells.

#include "gpu/engines/octree/count.hpp"

namespace collided {

constexpr uint32_t kCrowded = 64;   ///< triangles of a cell that is worth a brick
constexpr uint32_t kMaxSpread = 4;  ///< bottom cells a triangle may cover on average, or the brick is a dead end

/// Opens bricks for the crowded cells of the base level.
struct OpenFirstBricks {
  Tree tree;

  COLLIDED_HD void operator()(uint64_t i) const {
    const LevelGrid grid = *tree.grid;
    const uint32_t number = static_cast<uint32_t>(i), cell = level_offset(grid.base) + number;
    open_brick(tree, 0, cell, tree.counts[cell] >= kCrowded, grid.base, morton_coords(number));
  }

  COLLIDED_HD static void open_brick(const Tree& tree, int round, uint32_t cell, bool crowded, int level,
                                     const Coords& coords) {
    tree.type[cell] = kInternal;
    if (!crowded) return;
    const uint64_t brick = tree.first_brick(round) + claim_slot(tree.brick_counters[round]);
    if (brick >= tree.bricks.size()) return;
    tree.bricks[brick] = {cell, level, coords};
    tree.reach[brick] = 0;
    tree.slot[cell] = static_cast<uint32_t>(brick);
    tree.type[cell] = kRefined;
  }
};

/// Opens bricks for the crowded bottom cells of the last round's bricks; one item a brick.
struct OpenBricks {
  using Shared = Nothing;
  static constexpr uint32_t kGroupSize = 128;
  Tree tree;
  int round;  ///< that the new bricks belong to, > 0

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Nothing&) const {
    const uint32_t parent = static_cast<uint32_t>(tree.first_brick(round - 1) + i);
    if (parent >= tree.bricks.size()) return;
    const Brick root = tree.bricks[parent];
    const bool fans_out = tree.reach[parent] > kMaxSpread * uint64_t{tree.counts[root.parent]};
    constexpr uint32_t kBottom = 1u << (3 * kBrickLevels);
    for (uint32_t k = group.rank; k < kBottom; k += group.size) {
      const uint32_t cell = tree.brick_cell(parent, level_offset(kBrickLevels) + k);
      const Coords below = morton_coords(k);
      OpenFirstBricks::open_brick(tree, round, cell, !fans_out && tree.counts[cell] >= kCrowded,
                                  root.level + kBrickLevels,
                                  {(root.cell.x << kBrickLevels) + below.x, (root.cell.y << kBrickLevels) + below.y,
                                   (root.cell.z << kBrickLevels) + below.z});
    }
  }
};

struct ClearBricks {
  using Shared = Nothing;
  static constexpr uint32_t kGroupSize = 128;
  Tree tree;
  int round;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Nothing&) const {
    const uint64_t brick = tree.first_brick(round) + i;
    if (brick >= tree.bricks.size()) return;
    uint32_t* counts = tree.counts.data + tree.brick_cell(static_cast<uint32_t>(brick), 1);
    for (uint32_t k = group.rank; k < kBrickCells; k += group.size) counts[k] = 0;
  }
};

/// Lists which triangles are in which bricks of a round.
struct ListInBricks {
  Tree tree;
  int round;

  COLLIDED_HD uint32_t look(uint32_t cell) const { return tree.type[cell]; }
  COLLIDED_HD uint32_t find(uint32_t cell, uint32_t type) const {
    return type == kRefined ? tree.slot[cell] : kNothing;
  }
  COLLIDED_HD void put(uint32_t triangle, uint32_t brick) const {
    const uint64_t place = tree.first_brick_item(round) + claim_slot(tree.brick_item_counters[round]);
    if (place < tree.brick_items.size()) tree.brick_items[place] = {triangle, brick};
  }
};
/// Those of the first round, by the base cells of each triangle.
struct ListInFirstBricks {
  using Item = CoveredCells;
  static constexpr bool kWalks = false;
  ListInBricks list;
  CellsOfTriangles cells;

  COLLIDED_HD Item item(uint64_t i) const { return cells.from_level(cells.grid->base, i); }
  COLLIDED_HD uint32_t look(uint32_t cell) const { return list.look(cell); }
  COLLIDED_HD uint32_t find(uint32_t cell, uint32_t type) const { return list.find(cell, type); }
  COLLIDED_HD void act(const Item& item, uint32_t brick) const { list.put(item.triangle, brick); }
};
struct ListLargeInFirstBricks {
  using Item = ManyCoveredCells;
  ListInBricks list;
  CellsOfLarge cells;

  COLLIDED_HD Item item(uint64_t i) const { return cells.from_level(cells.grid->base, i); }
  COLLIDED_HD uint32_t look(uint32_t cell) const { return list.look(cell); }
  COLLIDED_HD uint32_t find(uint32_t cell, uint32_t type) const { return list.find(cell, type); }
  COLLIDED_HD void act(const Item& item, uint32_t brick) const { list.put(item.triangle, brick); }
};

/// The cells of a round's bricks that their triangles cover.
struct CellsInBricks {
  using Item = CoveredInBrick;
  Tree tree;
  Span<const Box<float>> boxes;
  int round;

  COLLIDED_HD Item operator()(uint64_t i) const { return from_level(1, i); }
  /// Those from a level below the brick's root on.
  COLLIDED_HD Item from_level(int top, uint64_t i) const {
    const uint64_t place = tree.first_brick_item(round) + i;
    if (place >= tree.brick_items.size()) return {};
    const BrickItem item = tree.brick_items[place];
    return {tree, item, tree.grid->deepest_range(boxes[item.triangle]), top};
  }
};
/// Those of a later round, by the bottom cells of the round before.
struct ListInNextBricks {
  using Item = CoveredInBrick;
  static constexpr bool kWalks = false;
  ListInBricks list;
  CellsInBricks before;

  COLLIDED_HD Item item(uint64_t i) const { return before.from_level(kBrickLevels, i); }
  COLLIDED_HD uint32_t look(uint32_t cell) const { return list.look(cell); }
  COLLIDED_HD uint32_t find(uint32_t cell, uint32_t type) const { return list.find(cell, type); }
  COLLIDED_HD void act(const Item& item, uint32_t brick) const { list.put(item.triangle, brick); }
};

/// Counts the triangles of the bricks of one round.
struct CountInBricks {
  using Item = CoveredInBrick;
  static constexpr bool kWalks = false;
  CellsInBricks cells;

  COLLIDED_HD Item item(uint64_t i) const {
    const Item item = cells(i);
    if (item.parts > 0) atomic_add(cells.tree.reach[cells.tree.brick_of(item.first)], item.bottom_cells());
    return item;
  }
  COLLIDED_HD static uint32_t look(uint32_t cell) { return AnyCell::look(cell); }
  COLLIDED_HD static uint32_t find(uint32_t cell, uint32_t seen) { return AnyCell::find(cell, seen); }
  COLLIDED_HD void act(const Item&, uint32_t cell) const { count_in(cells.tree.counts, cell); }
};

}  // namespace collided
