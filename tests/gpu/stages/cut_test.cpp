// The two stages against the definition: the cheapest of all cuts, found by plain recursion.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/gpu/stages/octree_fixture.hpp"

namespace collided::test {
namespace {

constexpr CutCost kTestsAlone{CutRule::kTwoStage, 0};

struct CutOctree : TestOctree {
  std::vector<uint32_t> leaves(const CutCost& cost = kTestsAlone) {
    cut(cost);
    std::vector<uint32_t> out;
    for (uint32_t cell = level_offset(grid.top); cell < level_offset(grid.base + 1); ++cell)
      if (type[cell] == kLeaf && is_real_leaf(tree(), cell)) out.push_back(cell);
    return out;
  }

  uint64_t cheapest(uint32_t cell, uint64_t per_registration) const {
    const uint64_t n = counts[cell], own = n < 2 ? 0 : tests_of(n) + per_registration * n;
    if (level_of(cell) == grid.base) return own;
    uint64_t below = 0;
    for (uint32_t k = 1; k <= 8; ++k) below += cheapest(8 * cell + k, per_registration);
    return std::min(own, below);
  }
};

/// Triangles that reach over neighbouring base cells, so that a parent has fewer than its children together.
CutOctree random_tree(uint32_t seed, int top, int base) {
  std::mt19937 random(seed);
  CutOctree tree;
  tree.grid.top = top;
  tree.grid.base = base;
  const uint32_t side = 1u << base;
  const int triangles = 1 + static_cast<int>(random() % 60);
  for (int t = 0; t < triangles; ++t) {
    const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
    const Coords lo{below(side), below(side) / 2, below(side) / 4};
    const Coords hi{std::min(side - 1, lo.x + below(3)), std::min(side - 1, lo.y + below(3)),
                    std::min(side - 1, lo.z + below(3))};
    const LevelsOfCells covered({lo, hi}, top, base);
    for (uint32_t k = 0; k < covered.cells(); ++k) ++tree.counts[covered.cell(k)];
  }
  return tree;
}

bool is_ancestor_or_self(uint32_t ancestor, uint32_t cell) {
  while (cell > ancestor) cell = (cell - 1) >> 3;
  return cell == ancestor;
}

void expect_cheapest(uint32_t seed, int top, int base, uint32_t per_registration) {
  SCOPED_TRACE(testing::Message() << "seed " << seed << ", levels " << top << " to " << base);
  CutOctree tree = random_tree(seed, top, base);
  const std::vector<uint32_t> leaves = tree.leaves({CutRule::kTwoStage, static_cast<float>(per_registration)});
  uint64_t cost = 0, best = 0;
  for (const uint32_t leaf : leaves) {
    const uint64_t n = tree.counts[leaf];
    if (n >= 2) cost += tests_of(n) + per_registration * n;
  }
  for (uint32_t root = level_offset(top); root < level_offset(top + 1); ++root)
    best += tree.cheapest(root, per_registration);
  EXPECT_EQ(cost, best);
  for (uint32_t cell = level_offset(base); cell < level_offset(base + 1); ++cell) {
    if (tree.counts[cell] == 0) continue;
    const auto above =
        std::count_if(leaves.begin(), leaves.end(), [&](uint32_t l) { return is_ancestor_or_self(l, cell); });
    ASSERT_EQ(above, 1) << "cell " << cell;
  }
}

TEST(Cut, IsTheCheapestOfAllAndPartitionsTheNonEmptyCells) {
  for (uint32_t seed = 0; seed < 200; ++seed)
    expect_cheapest(seed, static_cast<int>(seed % 4), 3, seed % 2 == 0 ? 0 : 4);
}

// Deeper hierarchies take several steps, which meet at the cells between them.
TEST(Cut, StepsOfADeepHierarchyMeet) {
  for (uint32_t seed = 0; seed < 24; ++seed) expect_cheapest(seed, static_cast<int>(seed % 5), 4, seed % 3);
  for (uint32_t seed = 0; seed < 6; ++seed) expect_cheapest(seed, static_cast<int>(seed % 3), 6, seed % 3);
}

// Fig. 4: one subdivision alone would not pay, two levels do; the one-stage top-down form stops before.
TEST(Cut, LooksPastALevelThatDoesNotPay) {
  CutOctree tree;
  for (int level = 0; level <= 2; ++level) tree.counts[level_offset(level)] = 6;  // all six stay in one child
  for (uint32_t k = 0; k < 6; ++k) tree.counts[level_offset(3) + k] = 1;          // and part at the base
  EXPECT_EQ(tree.leaves().size(), 6u);
  EXPECT_EQ(tree.leaves({CutRule::kTopDown, 0}), std::vector<uint32_t>{0});
}

// One child is better left split, so the one-stage bottom-up form merges nothing above it, though that would pay.
TEST(Cut, BottomUpFormStopsAtASiblingThatWasNotMerged) {
  CutOctree tree;
  tree.grid.base = 2;
  const uint32_t base = level_offset(2);
  for (uint32_t k = 0; k < 8; ++k) tree.counts[base + k] = 4;  // the first child: spread over its children
  tree.counts[level_offset(1)] = 20;
  for (uint32_t child = 1; child < 8; ++child) {
    tree.counts[level_offset(1) + child] = 20;
    tree.counts[base + 8 * child] = 20;
  }
  tree.counts[0] = 20;
  EXPECT_EQ(tree.leaves(), std::vector<uint32_t>{0});
  const std::vector<uint32_t> split = tree.leaves({CutRule::kBottomUp, 0});
  EXPECT_EQ(split.size(), 8u + 7u);
}

TEST(Cut, GridKeepsTheBaseLevel) {
  CutOctree tree = random_tree(3, 0, 3);
  for (const uint32_t leaf : tree.leaves({CutRule::kGrid, 0})) EXPECT_EQ(level_of(leaf), 3);
}

TEST(Cut, MergesOnATie) {
  CutOctree tree;
  for (int level = 0; level <= 3; ++level) tree.counts[level_offset(level)] = 5;
  EXPECT_EQ(tree.leaves(), std::vector<uint32_t>{0});
}

}  // namespace
}  // namespace collided::test
