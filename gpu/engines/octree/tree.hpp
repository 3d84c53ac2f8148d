#pragma once
// What the stages of the octree grid share: per-cell arrays and bricks.

#include "gpu/base/lattice.hpp"
#include "gpu/exec/atomic.hpp"
#include "gpu/exec/counted.hpp"

namespace collided {

/// Cells without triangles are inactive. kRefined is an internal cell whose children are those of a brick.
enum CellType : uint8_t { kInactive = 0, kInternal = 1, kLeaf = 2, kRefined = 3 };

constexpr uint32_t kNoLeaf = kNothing;

/// The next kBrickLevels levels below a crowded cell.
struct Brick {
  uint32_t parent;  ///< index of the cell
  int level;        ///< of that cell
  Coords cell;
};

/// A triangle that overlaps the root of a brick.
struct BrickItem {
  uint32_t triangle, brick;
};

struct Tree {
  const LevelGrid* grid;
  uint32_t dense_cells;   ///< of all dense levels that the scene may use
  Span<uint32_t> counts;  ///< triangles that overlap a cell; dense cells, then those of the bricks
  Span<uint8_t> type;     ///< CellType
  Span<uint32_t> slot;    ///< kLeaf: the leaf's number, or kNoLeaf; kRefined: the brick's number
  Span<Brick> bricks;
  Span<uint32_t> reach;    ///< of each brick: how many of its bottom cells its triangles overlap, added up
  Span<float> brick_cost;  ///< of the best cut below each brick's root
  Span<BrickItem> brick_items;
  uint64_t* brick_counters;       ///< bricks of each round
  uint64_t* brick_item_counters;  ///< their triangles likewise
  int rounds;                     ///< of refinement

  /// Index of a cell of a brick: its number below the brick's root, which is not part of the brick.
  COLLIDED_HD uint32_t brick_cell(uint32_t brick, uint32_t number) const {
    return dense_cells + brick * kBrickCells + number - 1;
  }
  /// The brick of such a cell.
  COLLIDED_HD uint32_t brick_of(uint32_t cell) const { return (cell - dense_cells) / kBrickCells; }

  /// First brick of a round; of round `rounds`: the number of all.
  COLLIDED_HD uint64_t first_brick(int round) const { return sum_before(round, brick_counters, bricks.size()); }
  COLLIDED_HD uint64_t first_brick_item(int round) const {
    return sum_before(round, brick_item_counters, brick_items.size());
  }

 private:
  COLLIDED_HD static uint64_t sum_before(int round, const uint64_t* counters, uint64_t most) {
    uint64_t sum = 0;
    for (int r = 0; r < round; ++r) sum += counters[r];
    return sum < most ? sum : most;
  }
};

}  // namespace collided
