// Virtual subdivision: how large cells are, and the order by control bits in which a pair is tested in one cell alone.

#include "gpu/engines/octree/subdivision.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "gpu/engines/octree/cell_grid.hpp"
#include "gpu/search/cpu/pair_search.hpp"
#include "tests/gpu/stages/octree_fixture.hpp"

namespace collided::test {
namespace {

using Pair = std::pair<uint32_t, uint32_t>;

/// Members of one leaf of a grid of eight cells a side, of length 1, whose boxes all cover the leaf's cell.
struct OneCell {
  static constexpr Coords kCell{3, 3, 3};

  OneCell(uint32_t count, uint32_t seed) : registered(count), ordered(count, ~0u), leaves{{kCell, 3, count, 0}} {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> before(2, 3.9f), behind(3.9f, 5);
    for (uint32_t k = 0; k < count; ++k) {
      boxes.push_back({{before(random), before(random), before(random)}, {behind(random), behind(random), 4}});
      registered[k] = count - 1 - k;
    }
    for (uint32_t row = 0; row < tiles_of(count); ++row)
      for_each_item_of_row(0, count, row, [&](uint64_t, const PairItem& item) { items.push_back(item); });
    totals[LeafSum::kLeaves] = 1;
    totals[LeafSum::kTests] = tests_of(count);
    totals[LeafSum::kItems] = items.size();
    totals[LeafSum::kRegistrations] = count;
  }

  LeafPairs source() {
    return {&grid,          {},      span_of(boxes),   span_of(leaves), span_of(registered),
            span_of(items), &totals, registered.size()};
  }
  LeafPairs ordered_source() {
    LeafPairs made = source();
    made.registered = span_of(ordered), made.by_start = span_of(by_start);
    return made;
  }
  void order() {
    const uint64_t one = 1;
    exec.for_each_group("order", {&one, 1}, OrderByControlBits{source(), span_of(ordered), span_of(by_start), &totals});
  }
  uint32_t axes(uint32_t triangle) { return source().axes_of_start(leaves[0], boxes[triangle]); }
  /// By a thread that begins with an item in the middle, as one that helps others does.
  std::vector<Pair> found(const LeafPairs& pairs) {
    std::vector<Pair> found;
    LeafTiles tiles;
    for (uint64_t i = 0; i < items.size(); ++i)
      visit_item(pairs, (i + items.size() / 2) % items.size(), tiles,
                 [&](uint32_t a, uint32_t b) { found.push_back(std::minmax(a, b)); });
    std::sort(found.begin(), found.end());
    return found;
  }
  /// Pairs of members whose control bits let them be tested.
  uint64_t allowed() {
    uint64_t sum = 0;
    for (uint32_t a = 0; a < boxes.size(); ++a)
      for (uint32_t b = 0; b < a; ++b) sum += LeafPairs::reports(axes(a), axes(b)) ? 1 : 0;
    return sum;
  }

  CpuExec exec{2, 0};
  LevelGrid grid{{0, 0, 0}, static_cast<float>(1u << kDeepest) / 8, 3, 3};
  std::vector<Box<float>> boxes;
  std::vector<uint32_t> registered, ordered;
  std::vector<Leaf> leaves;
  std::vector<PairItem> items;
  std::vector<MembersByStart> by_start{1};
  LeafTotals totals{};
};

class ControlBits : public ::testing::TestWithParam<uint32_t> {};

TEST_P(ControlBits, PutTheMembersOfALeafInOrder) {
  OneCell cell(GetParam(), 1);
  cell.order();
  const auto place = [&](uint32_t triangle) { return MembersByStart::place_of(cell.axes(triangle)); };
  EXPECT_TRUE(std::ranges::is_sorted(cell.ordered, {}, place));
  std::vector<uint32_t> members = cell.ordered;
  std::ranges::sort(members);
  for (uint32_t k = 0; k < GetParam(); ++k) ASSERT_EQ(members[k], k);
  for (uint32_t p = 0; p < MembersByStart::kPlaces; ++p)
    EXPECT_EQ(cell.by_start[0].end[p],
              std::ranges::count_if(cell.ordered, [&](uint32_t triangle) { return place(triangle) <= p; }));
}

TEST_P(ControlBits, LeaveTheLeafsPairsAsTheyAre) {
  OneCell cell(GetParam(), 2);
  const std::vector<Pair> expected = cell.found(cell.source());
  cell.order();
  EXPECT_EQ(cell.found(cell.ordered_source()), expected);
}

TEST_P(ControlBits, TakeOffTheTestsThatTheySave) {
  OneCell cell(GetParam(), 3);
  cell.order();
  EXPECT_EQ(cell.totals[LeafSum::kTests], cell.allowed());
}

TEST_P(ControlBits, LetAMemberMeetARunOfThoseAfterIt) {
  OneCell cell(GetParam(), 4);
  cell.order();
  const MembersByStart& members = cell.by_start[0];
  for (uint32_t a = 0; a < GetParam(); ++a) {
    ASSERT_LE(members.end_for(a), members.end_for(a > 0 ? a - 1 : 0));
    for (uint32_t b = std::max(a + 1, members.end_for(a)); b < GetParam(); ++b)
      ASSERT_FALSE(LeafPairs::reports(cell.axes(cell.ordered[a]), cell.axes(cell.ordered[b]))) << a << ", " << b;
  }
}

INSTANTIATE_TEST_SUITE_P(Members, ControlBits, ::testing::Values(2, 3, 8, 31, 32, 33, 100, 300));

TEST(MembersByStart, PlacesOfComplementsAreAsFarFromTheEnds) {
  std::set<uint32_t> places;
  for (uint32_t axes = 0; axes < 8; ++axes) {
    places.insert(MembersByStart::place_of(axes));
    EXPECT_EQ(MembersByStart::place_of(axes) + MembersByStart::place_of(7 - axes), 7u);
  }
  EXPECT_EQ(places.size(), 8u);
}

// What had no room was not written.
TEST(OrderByControlBits, WaitsForAStepThatHasRoom) {
  OneCell cell(10, 5);
  cell.totals[LeafSum::kRegistrations] = 11;
  const uint64_t tests = cell.totals[LeafSum::kTests];
  cell.order();
  EXPECT_EQ(std::ranges::count(cell.ordered, ~0u), 10);
  EXPECT_EQ(cell.totals[LeafSum::kTests], tests);
}

/// Side of a cell among boxes of these sizes in a scene of side 100.
double cell_of(const std::vector<float>& sizes) {
  const Box<float> bounds{{0, 0, 0}, {100, 100, 100}};
  std::vector<Box<float>> boxes;
  uint64_t sum = 0;
  for (const float size : sizes)
    sum += extent_of(boxes.emplace_back(Vec3<float>{}, Vec3<float>{size, size, size}), bounds);
  const OrdinaryExtentOf of{{&bounds, &sum, sizes.size()}, span_of(boxes)};
  OrdinaryExtents ordinary{};
  for (uint64_t i = 0; i < sizes.size(); ++i) ordinary = AddOrdinaryExtents{}(ordinary, of(i));
  LevelGrid grid{};
  SpanCells<OrdinaryMean>{&bounds, {&bounds, &ordinary}, 1, kMaxLevel, &grid}(0);
  return (1u << (kDeepest - grid.base)) / static_cast<double>(grid.cells_per_length);
}

TEST(VirtualSubdivision, CellsAreAsLargeAsOrdinaryTriangles) {
  EXPECT_NEAR(cell_of({2, 4}), 3, 1e-3);
  EXPECT_NEAR(cell_of({2, 4, 2, 4, 2, 4, 2, 4, 100}), 3, 1e-3) << "the large one does not count";
  EXPECT_NEAR(cell_of({5}), 5, 1e-3);
  EXPECT_NEAR(cell_of({0, 0}), 100.0 / (1 << kMaxLevel), 1e-3);
}

}  // namespace
}  // namespace collided::test
