#pragma once
// Sparse levels below the dense ones, for scenes of mixed scale: crowded cells get bricks, round by round.
// What is refined affects speed alone, so both guards may be rough: a brick is opened only where many triangles are,
// and below a brick only if its triangles did not spread over too many of its cells.

#include "gpu/octree/count.hpp"

namespace collided {

constexpr uint32_t kCrowded = 64;    ///< triangles of a cell that is worth a brick
constexpr uint32_t kMostSpread = 4;  ///< bottom cells a triangle may cover on average, or the brick is a dead end

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
    uint32_t* counts = tree.counts.data + brick_cell(static_cast<uint32_t>(brick), 1);
    for (uint32_t k = 0; k < kBrickCells; ++k) counts[k] = 0;
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
    const bool fans_out = tree.reach[parent] > kMostSpread * uint64_t{tree.counts[root.parent]};
    constexpr uint32_t kBottom = 1u << (3 * kBrickLevels);
    for (uint32_t k = group.rank; k < kBottom; k += group.size) {
      const uint32_t cell = brick_cell(parent, level_offset(kBrickLevels) + k);
      const Coords below = morton_coords(k);
      OpenFirstBricks::open_brick(tree, round, cell, !fans_out && tree.counts[cell] >= kCrowded,
                                  root.level + kBrickLevels,
                                  {(root.cell.x << kBrickLevels) + below.x, (root.cell.y << kBrickLevels) + below.y,
                                   (root.cell.z << kBrickLevels) + below.z});
    }
  }
};

/// Counts the triangles of the bricks of one round.
struct CountInBricks {
  Tree tree;
  Span<const Box<float>> boxes;
  int round;

  COLLIDED_HD void operator()(uint64_t triangle) const {
    const CellRange deepest = tree.grid->deepest_range(boxes[triangle]);
    if (shifted(deepest, kDeepest - tree.grid->base).size() <= kManyCells) count(deepest, 0, 1);
  }
  COLLIDED_HD void count(const CellRange& deepest, uint32_t rank, uint32_t threads) const {
    visit_bricks(tree, deepest, round, rank, threads, [&](uint32_t cell, int at, int depth, uint32_t brick) {
      if (at != round) return;
      count_up(tree.counts[cell]);
      if (depth == kBrickLevels) count_up(tree.reach[brick]);
    });
  }
};

struct CountInBricksOfLarge {
  using Shared = Nothing;
  static constexpr uint32_t kGroupSize = 32;
  CountInBricks count;
  Span<const uint32_t> large;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Nothing&) const {
    count.count(count.tree.grid->deepest_range(count.boxes[large[i]]), group.rank, group.size);
  }
};

}  // namespace collided
