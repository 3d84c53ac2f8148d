// The cells that boxes cover, by their places, one by one and shared by threads.

#include "gpu/engines/octree/covered.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace collided::test {
namespace {

using Cells = std::vector<uint32_t>;

/// Level by level downwards, each in rows along x.
Cells cells_of(const CellRange& range, int top, int base) {
  Cells cells;
  for (int level = top; level <= base; ++level) {
    const auto [lo, hi] = shifted(range, base - level);
    for (uint32_t z = lo.z; z <= hi.z; ++z)
      for (uint32_t y = lo.y; y <= hi.y; ++y)
        for (uint32_t x = lo.x; x <= hi.x; ++x) cells.push_back(cell_id(level, {x, y, z}));
  }
  return cells;
}

template <class Item>
Cells by_place(const Item& item) {
  Cells cells;
  for (uint32_t k = 0; k < item.parts; ++k) cells.push_back(item.part(k));
  return cells;
}
template <class Item>
Cells by_walk(const Item& item) {
  Cells cells;
  CellWalk walk = item.walk();
  for (uint32_t k = 0; k < item.parts; ++k) cells.push_back(walk.next());
  for (int k = 0; k < 8; ++k) walk.next();  // as the lanes do that wait for others
  return cells;
}

/// Ranges of cells, up to `widest` cells wide, small ones and those at the ends of the axes more often than others.
class Ranges {
 public:
  Ranges(int level, uint32_t widest) : side_(1u << level), widest_(std::min(widest, side_)) {}

  CellRange next() {
    CellRange range{};
    set(range.lo.x, range.hi.x), set(range.lo.y, range.hi.y), set(range.lo.z, range.hi.z);
    return range;
  }

 private:
  uint32_t side_, widest_;
  std::mt19937 random_{7};

  uint32_t below(uint32_t n) { return static_cast<uint32_t>(random_() % n); }
  void set(uint32_t& lo, uint32_t& hi) {
    const uint32_t width = 1 + (below(2) == 0 ? below(std::min(widest_, 3u)) : below(widest_));
    const uint32_t most = side_ - width;
    lo = below(4) == 0 ? most * below(2) : below(most + 1);
    hi = lo + width - 1;
  }
};

CellRange at_deepest(const CellRange& range, int level) {
  const int s = kDeepest - level;
  return {{range.lo.x << s, range.lo.y << s, range.lo.z << s}, {range.hi.x << s, range.hi.y << s, range.hi.z << s}};
}

TEST(Covered, DenseCellsAreTheSameByPlaceAndByWalk) {
  for (int base = 0; base <= kMaxLevel; ++base)
    for (int top = 0; top <= base; ++top) {
      Ranges ranges(base, 6);
      for (int i = 0; i < 300; ++i) {
        const CellRange range = ranges.next();
        const CoveredCells item(3, {{}, 1, top, base}, at_deepest(range, base), top);
        const bool large = range.size() > CoveredCells::kMaxBase;
        const Cells expected = large ? Cells{} : cells_of(range, top, base);
        ASSERT_EQ(by_place(item), expected) << top << " to " << base;
        ASSERT_EQ(by_walk(item), expected) << top << " to " << base;
      }
    }
}

TEST(Covered, CellsOfABrickAreTheSameByPlaceAndByWalk) {
  constexpr uint32_t kBrick = 2;
  const Coords root{5, 0, 127};
  std::vector<Brick> bricks(kBrick + 1, {0, kMaxLevel, root});
  Tree tree{};
  tree.dense_cells = level_offset(kMaxLevel + 1);
  tree.bricks = {bricks.data(), bricks.size()};
  Ranges ranges(kBrickLevels, 8);
  for (int top = 1; top <= kBrickLevels; ++top)
    for (int i = 0; i < 500; ++i) {
      const CellRange below = ranges.next();
      const auto in_brick = [&](const Coords& c) {
        return Coords{(root.x << kBrickLevels) + c.x, (root.y << kBrickLevels) + c.y, (root.z << kBrickLevels) + c.z};
      };
      const CellRange deepest = at_deepest({in_brick(below.lo), in_brick(below.hi)}, kMaxLevel + kBrickLevels);
      Cells expected = cells_of(below, top, kBrickLevels);
      for (uint32_t& cell : expected) cell = tree.brick_cell(kBrick, cell);
      const CoveredInBrick item(tree, {1, kBrick}, deepest, top);
      ASSERT_EQ(by_place(item), expected) << top;
      ASSERT_EQ(by_walk(item), expected) << top;
      EXPECT_EQ(item.bottom_cells(), below.size());
    }
}

struct ListFound {
  using Item = ManyCoveredCells;
  Item large;
  Cells& found;

  Item item(uint64_t) const { return large; }
  static uint32_t look(uint32_t) { return 0; }
  static uint32_t find(uint32_t cell, uint32_t) { return cell; }
  void act(const Item&, uint32_t cell) const { found.push_back(cell); }
};

TEST(Covered, EachCellOfALargeTriangleIsFoundOnceByManyThreads) {
  const LevelGrid grid = grid_over({{0, 0, 0}, {1, 1, 1}}, 2, kMaxLevel);
  for (const Box<float>& box :
       {Box<float>{{0.1f, 0.2f, 0.3f}, {0.25f, 0.21f, 0.4f}}, Box<float>{{0, 0, 0}, {1, 1, 1}}}) {
    Cells expected = cells_of(grid.range(grid.base, box), grid.top, grid.base);
    std::sort(expected.begin(), expected.end());
    for (const uint32_t threads : {1u, 2u, 5u, 128u}) {
      Cells found;
      const PartsOfItem<ListFound> work{{{3, grid, grid.deepest_range(box), grid.top}, found}};
      Nothing nothing;
      for (uint32_t rank = 0; rank < threads; ++rank) work(0, {rank, threads}, nothing);
      std::sort(found.begin(), found.end());
      EXPECT_EQ(found, expected) << threads;
    }
  }
}

TEST(Covered, AWalkBeginsAtAnyCell) {
  for (int base = 0; base <= 4; ++base)
    for (int top = 0; top <= base; ++top) {
      Ranges ranges(base, 16);
      for (int i = 0; i < 20; ++i) {
        const CellRange range = ranges.next();
        const ManyCoveredCells item(3, {{}, 1, top, base}, at_deepest(range, base), top);
        const Cells expected = cells_of(range, top, base);
        ASSERT_EQ(by_place(item), expected);
        const uint32_t stride = 1 + item.parts / 50;
        for (uint32_t from = 0; from < item.parts; from += stride) {
          CellWalk walk = item.walk_from(from);
          for (uint32_t k = from; k < item.parts; ++k) ASSERT_EQ(walk.next(), expected[k]) << from << " " << k;
        }
      }
    }
}

}  // namespace
}  // namespace collided::test
