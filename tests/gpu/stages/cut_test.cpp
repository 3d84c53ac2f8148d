// The two stages against the definition: the cheapest of all cuts, found by plain recursion.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "gpu/exec/cpu_exec.hpp"
#include "gpu/octree/bottom_up.hpp"
#include "gpu/octree/top_down.hpp"

namespace collided::test {
namespace {

template <class T>
Span<T> span_of(std::vector<T>& v) {
  return {v.data(), v.size()};
}

struct Tree {
  LevelGrid grid{{0, 0, 0}, 1, 0, 3};
  std::vector<uint32_t> counts = std::vector<uint32_t>(level_offset(4), 0);
  std::vector<uint64_t> cost = std::vector<uint64_t>(level_offset(4), 0);
  std::vector<uint8_t> type = std::vector<uint8_t>(level_offset(4), 0);

  std::vector<uint32_t> leaves() {
    CpuExec exec(1, 0);
    bottom_up(exec, grid, span_of(counts), span_of(cost), span_of(type));
    const uint32_t first = level_offset(grid.top);
    std::vector<uint32_t> slot(counts.size() - first + 1, 7);
    exec.for_each("mark", slot.size(), MarkRealLeaves{grid.top, first, span_of(type), span_of(slot)});
    std::vector<uint32_t> out;
    for (uint32_t i = 0; i + 1 < slot.size(); ++i)
      if (slot[i] != 0) out.push_back(first + i);
    return out;
  }

  uint64_t cheapest(uint32_t cell) const {
    if (level_of(cell) == grid.base) return tests_of(counts[cell]);
    uint64_t below = 0;
    for (uint32_t k = 1; k <= 8; ++k) below += cheapest(8 * cell + k);
    return std::min(tests_of(counts[cell]), below);
  }
};

/// Triangles that reach over neighbouring base cells, so that a parent has fewer than its children together.
Tree random_tree(uint32_t seed, int top) {
  std::mt19937 random(seed);
  Tree tree;
  tree.grid.top = top;
  const int triangles = 1 + static_cast<int>(random() % 60);
  for (int t = 0; t < triangles; ++t) {
    const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
    const Coords lo{below(8), below(8), below(8)};
    const Coords hi{std::min(7u, lo.x + below(3)), std::min(7u, lo.y + below(3)), std::min(7u, lo.z + below(3))};
    for (int level = top; level <= 3; ++level) {
      const int s = 3 - level;
      const CellRange range{{lo.x >> s, lo.y >> s, lo.z >> s}, {hi.x >> s, hi.y >> s, hi.z >> s}};
      for (uint64_t rank = 0; rank < range.size(); ++rank) ++tree.counts[cell_id(level, range.cell(rank))];
    }
  }
  return tree;
}

bool is_ancestor_or_self(uint32_t ancestor, uint32_t cell) {
  while (cell > ancestor) cell = (cell - 1) >> 3;
  return cell == ancestor;
}

TEST(Cut, IsTheCheapestOfAllAndPartitionsTheNonEmptyCells) {
  for (uint32_t seed = 0; seed < 300; ++seed) {
    Tree tree = random_tree(seed, static_cast<int>(seed % 3));
    const std::vector<uint32_t> leaves = tree.leaves();
    uint64_t tests = 0, best = 0;
    for (const uint32_t leaf : leaves) tests += tests_of(tree.counts[leaf]);
    for (uint32_t root = level_offset(tree.grid.top); root < level_offset(tree.grid.top + 1); ++root)
      best += tree.cheapest(root);
    EXPECT_EQ(tests, best) << "seed " << seed;
    for (uint32_t cell = level_offset(3); cell < level_offset(4); ++cell) {
      const auto above =
          std::count_if(leaves.begin(), leaves.end(), [&](uint32_t l) { return is_ancestor_or_self(l, cell); });
      if (tree.counts[cell] != 0) {
        ASSERT_EQ(above, 1) << "seed " << seed << " cell " << cell;
      } else {
        ASSERT_LE(above, 1);
      }
    }
  }
}

// Fig. 4: one subdivision alone would not pay, two levels do.
TEST(Cut, LooksPastALevelThatDoesNotPay) {
  Tree tree;
  for (int level = 0; level <= 2; ++level) tree.counts[level_offset(level)] = 6;  // all six stay in one child
  for (uint32_t k = 0; k < 6; ++k) tree.counts[level_offset(3) + k] = 1;          // and part at the base
  const std::vector<uint32_t> leaves = tree.leaves();
  EXPECT_EQ(leaves.size(), 6u);
  EXPECT_EQ(tree.cost[0], 0u);
}

TEST(Cut, MergesOnATie) {
  Tree tree;
  for (int level = 0; level <= 3; ++level) tree.counts[level_offset(level)] = 5;
  EXPECT_EQ(tree.leaves(), std::vector<uint32_t>{0});
}

}  // namespace
}  // namespace collided::test
