// Grids whose cells come from the triangles: the size of the cells, and the cut of two levels.

#include "gpu/engines/octree/cell_grid.hpp"

#include <gtest/gtest.h>

#include "tests/gpu/stages/octree_fixture.hpp"

namespace collided::test {
namespace {

/// The grid over boxes of one size in a scene of side 100.
LevelGrid grid_of(float size, double cell_per_mean, int deepest = kMaxLevel) {
  const Box<float> bounds{{10, 10, 10}, {110, 60, 20}};
  const uint64_t extent = extent_of({{20, 20, 15}, {20 + size, 20, 15}}, bounds), sum = 50 * extent;
  LevelGrid grid{};
  SpanCells<MeanExtent>{&bounds, {&bounds, &sum, 50}, cell_per_mean, deepest, &grid}(0);
  return grid;
}

TEST(CellGrid, CellsAreAsLargeAsTheTriangles) {
  for (float size : {1.0f, 3.0f, 7.0f, 40.0f}) {
    const LevelGrid grid = grid_of(size, 1.5);
    const double cell = (1u << (kDeepest - grid.base)) / static_cast<double>(grid.cells_per_length);
    EXPECT_NEAR(cell, 1.5 * size, 1e-4 * size);
    EXPECT_GE(cell * (1 << grid.base), 100) << "the scene has cells everywhere";
    EXPECT_LT(cell * (1 << grid.base), 200) << "no more levels than the scene needs";
  }
}

TEST(CellGrid, StaysWithinTheDenseLevels) {
  const LevelGrid tiny = grid_of(0.001f, 1);
  EXPECT_EQ(tiny.base, kMaxLevel);
  EXPECT_NEAR(static_cast<double>(tiny.cells_per_length), (1u << kDeepest) / 100.0, 1);
  EXPECT_EQ(grid_of(100, 1.5).base, 0);
  EXPECT_EQ(grid_of(0, 1.5).base, kMaxLevel);
  EXPECT_EQ(grid_of(0.001f, 1, 3).base, 3);
}

TEST(CellGrid, IsCoarserWhereRegistrationsAreTooMany) {
  LevelTotals totals{};
  totals.cells[0] = 6400;
  for (int level = 1; level <= kMaxLevel; ++level) totals.cells[level] = 100ull << (3 * level);
  GridState state{};
  state.grid = {{0, 0, 0}, 1, 0, 5};
  ChooseCells{&totals, 2, &state}(0);  // 24 for a triangle: 153,600
  EXPECT_EQ(state.grid.base, 3);
  EXPECT_EQ(state.grid.top, 1);
  EXPECT_EQ(state.top_cells, 8u);
  EXPECT_EQ(state.base_cells, 512u);
}

TEST(CellGrid, OnlyCrowdedCellsAreDivided) {
  TestOctree octree;
  octree.grid.top = 1, octree.grid.base = 3;
  const uint32_t few = level_offset(1), many = few + 1, below = level_offset(3) + 64;
  octree.counts[few] = CutCrowded::kMaxMembers;
  octree.counts[many] = CutCrowded::kMaxMembers + 1;
  octree.counts[level_offset(2) + 8] = octree.counts[many];
  octree.counts[below] = octree.counts[below + 7] = 20;
  octree.counts[level_offset(3) + 1] = 5;  // below the cell with few
  for (uint64_t i = 0; i < 8; ++i) CutCrowded{octree.tree()}(i);
  EXPECT_EQ(octree.type[few], kLeaf);
  EXPECT_EQ(octree.type[many], kInternal);
  EXPECT_EQ(octree.type[level_offset(2) + 8], kInternal);
  EXPECT_EQ(octree.type[below], kLeaf);
  EXPECT_EQ(octree.type[below + 1], kInactive);
  EXPECT_TRUE(is_real_leaf(octree.tree(), below));
  EXPECT_FALSE(is_real_leaf(octree.tree(), level_offset(3) + 1));
}

}  // namespace
}  // namespace collided::test
