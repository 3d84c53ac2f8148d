// Section 3.2: the thresholds that open and close levels.

#include "gpu/engines/octree/levels.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "gpu/engines/octree/octree_planner.hpp"

namespace collided::test {
namespace {

TEST(Levels, FollowTheThresholdsOfThePaper) {
  struct Case {
    uint64_t at_top, at_base, rest;
    int top, base;
  };
  const Case cases[] = {
      {20, 500, 9480, 2, 6},  // 0.2 % at the top: one level up
      {0, 500, 9500, 4, 6},   // none at the top: one level down
      {5, 5000, 4995, 3, 6},  // between the thresholds: as it is
      {5, 9800, 195, 3, 7},   // 98 % at the base: one level finer
      {5, 200, 9795, 3, 5},   // 2 % at the base: one level coarser
  };
  for (const Case& c : cases) {
    uint64_t registrations[kMaxLevel + 1] = {};
    registrations[3] = c.at_top;
    registrations[4] = c.rest;
    registrations[6] = c.at_base;
    const ActiveLevels next = next_levels({3, 6}, registrations);
    EXPECT_EQ(next.top, c.top);
    EXPECT_EQ(next.base, c.base);
  }
}

TEST(Levels, StayWithinTheirBounds) {
  uint64_t registrations[kMaxLevel + 1] = {};
  registrations[kMaxLevel] = 10;
  EXPECT_EQ(next_levels({kMaxLevel, kMaxLevel}, registrations).base, kMaxLevel);
  registrations[kMaxLevel] = 0;
  registrations[0] = 10;
  EXPECT_EQ(next_levels({0, 0}, registrations).top, 0);
  uint64_t none[kMaxLevel + 1] = {};
  EXPECT_EQ(next_levels({2, 5}, none).base, 5);
}

TEST(Levels, DenseCellsAreBoundedByTheTriangles) {
  EXPECT_EQ(deepest_base(1), kBrickLevels);
  for (int level = kBrickLevels + 1; level <= kMaxLevel; ++level) {
    const uint64_t triangles = (uint64_t{1} << (3 * level)) / 128;
    EXPECT_EQ(deepest_base(triangles - 1), level - 1);
    EXPECT_EQ(deepest_base(triangles), level);
  }
  EXPECT_EQ(deepest_base(uint64_t{1} << 40), kMaxLevel);
}

TEST(Levels, StayAboveTheDeepestOfTheScene) {
  LevelTotals one_cell_each{};
  std::ranges::fill(one_cell_each.cells, 1);
  EXPECT_EQ(clamp_levels({.deepest = 4}, one_cell_each).base, 4);
  uint64_t registrations[kMaxLevel + 1] = {};
  registrations[4] = 10;
  EXPECT_EQ(next_levels({2, 4, 4}, registrations).base, 4);
  EXPECT_EQ(next_levels({2, 4, 5}, registrations).base, 5);
}

TEST(Levels, BaseNeverTakesMoreRegistrationsThanItsBound) {
  LevelTotals totals{};
  for (int level = 0; level <= kMaxLevel; ++level) totals.cells[level] = 100ull << (3 * level);
  EXPECT_EQ(clamp_levels({}, totals).base, 0);      // 8 a triangle at level 1 are too many at first
  EXPECT_EQ(clamp_levels({0, 6}, totals).base, 1);  // later 24 are the bound
  totals.cells[0] = 1u << 30;
  EXPECT_EQ(clamp_levels({0, 6}, totals).base, 6);  // wide enough: as wanted
}

TEST(Levels, FirstFrameLeavesOutTheCoarsestLevels) {
  LevelTotals totals{};
  std::ranges::fill(totals.cells, 1);
  EXPECT_EQ(clamp_levels({}, totals).base, kMaxLevel);
  EXPECT_EQ(clamp_levels({}, totals).top, 3);
  for (int level = 3; level <= kMaxLevel; ++level) totals.cells[level] = 1000;
  EXPECT_EQ(clamp_levels({}, totals).base, 2);
  EXPECT_EQ(clamp_levels({}, totals).top, 0);
}

/// A step that ran at levels 3 to 6, with so many of 10,000 registrations at the lowest.
StepState step_with(uint64_t at_base) {
  StepState step{};
  step.grid.grid.top = 3, step.grid.grid.base = 6;
  step.leaves.level_registrations[3] = 5;
  step.leaves.level_registrations[4] = 9'995 - at_base;
  step.leaves.level_registrations[6] = at_base;
  return step;
}

// Widened boxes made the levels coarser for the ordinary steps after, too, which found nothing wrong with 50 % at the
// lowest level: --engine auto then compared an octree at the wrong levels.
TEST(Levels, OfWidenedStepsAreTheirOwn) {
  OctreePlanner planner(1 << 20);
  planner.learn_levels(step_with(5'000), false);
  EXPECT_EQ(planner.levels(false).base, 6);
  EXPECT_EQ(planner.levels(true).base, 6);  // where there is nothing better to go by
  planner.learn_levels(step_with(200), true);
  EXPECT_EQ(planner.levels(true).base, 5);
  EXPECT_EQ(planner.levels(false).base, 6);
  EXPECT_EQ(planner.plan(Engine::kOctree, true, true).base, 5);
  EXPECT_EQ(planner.plan(Engine::kOctree, true, false).base, 6);
}

}  // namespace
}  // namespace collided::test
