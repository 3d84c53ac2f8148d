#pragma once
// Section 3.1, first of the two stages: the optimal cut by dynamic programming from the base level up.
// A cell becomes a leaf if its own tests are no more than the best of its children together; otherwise its entry
// is replaced by their sum. On a tie the parent wins: fewer registrations for the same tests.

#include "gpu/math/lattice.hpp"

namespace collided {

COLLIDED_HD inline uint64_t tests_of(uint64_t triangles) { return triangles < 2 ? 0 : triangles * (triangles - 1) / 2; }

enum CellType : uint8_t { kInactive = 0, kInternal = 1, kLeaf = 2 };

struct MarkBaseCells {
  uint32_t first;  ///< id of the level's first cell
  Span<const uint32_t> counts;
  Span<uint64_t> cost;
  Span<uint8_t> type;

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint64_t cell = first + i;
    cost[cell] = tests_of(counts[cell]);
    type[cell] = counts[cell] == 0 ? kInactive : kLeaf;
  }
};

struct MergeChildrenIntoParent {
  uint32_t first;
  Span<const uint32_t> counts;
  Span<uint64_t> cost;
  Span<uint8_t> type;

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint64_t cell = first + i;
    uint64_t children = 0;
    for (int k = 1; k <= 8; ++k) children += cost[8 * cell + k];
    const uint64_t own = tests_of(counts[cell]);
    const bool leaf = own <= children;
    cost[cell] = leaf ? own : children;
    type[cell] = counts[cell] == 0 ? kInactive : leaf ? kLeaf : kInternal;
  }
};

template <class Exec>
void bottom_up(Exec& exec, const LevelGrid& grid, Span<const uint32_t> counts, Span<uint64_t> cost,
               Span<uint8_t> type) {
  const auto cells_at = [](int level) { return uint64_t{1} << (3 * level); };
  exec.for_each("mark_base_cells", cells_at(grid.base), MarkBaseCells{level_offset(grid.base), counts, cost, type});
  for (int level = grid.base - 1; level >= grid.top; --level)
    exec.for_each("merge_children", cells_at(level), MergeChildrenIntoParent{level_offset(level), counts, cost, type});
}

}  // namespace collided
