#include "client/cli/picture/marks.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace collided::cli {
namespace {

using Corners = std::array<scenes::Vec3d, 3>;
using Segment = std::array<scenes::Vec3d, 2>;

constexpr Corners kFloor{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};

Segment sorted(Segment ends) {
  std::sort(ends.begin(), ends.end());
  return ends;
}

TEST(CrossingOf, ASegmentInsideOneTriangleEndsWhereTheOtherOneDoes) {
  const Corners upright{{{1, 1, -1}, {1, 1, 1}, {2, 1, 0}}};
  const Segment expected{{{1, 1, 0}, {2, 1, 0}}};
  EXPECT_EQ(sorted(crossing_of(kFloor, upright)), expected);
  EXPECT_EQ(sorted(crossing_of(upright, kFloor)), expected);
}

TEST(CrossingOf, ASegmentAcrossABorderEndsThere) {
  const Corners upright{{{-1, 1, -1}, {-1, 1, 1}, {1, 1, 0}}};
  EXPECT_EQ(sorted(crossing_of(kFloor, upright)), (Segment{{{0, 1, 0}, {1, 1, 0}}}));
}

TEST(CrossingOf, TrianglesInOnePlaneOrThatOnlyTouchHaveAPoint) {
  EXPECT_EQ(crossing_of(kFloor, kFloor), (Segment{kFloor[0], kFloor[0]}));
  const Segment touch = crossing_of(kFloor, {{{1, 1, 0}, {1, 1, 1}, {2, 1, 1}}});
  EXPECT_EQ(touch[0], touch[1]);
}

TEST(MarkCrossings, NamesTheElementsOfBoth) {
  const std::vector<scenes::Vec3d> positions{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, -1}, {1, 1, 1}, {2, 1, 0}};
  const std::vector<Element> elements{{0, 1, 2}, {3, 4, 5}};
  client::Contacts pairs;
  pairs.elements = {{0, 1}};
  Marks marks;
  EXPECT_TRUE(marks.is_empty());
  mark_crossings(marks, pairs, elements, positions);
  ASSERT_EQ(marks.crossings.size(), 1u);
  EXPECT_EQ(sorted(marks.crossings[0]), (Segment{{{1, 1, 0}, {2, 1, 0}}}));
  EXPECT_EQ(marks.crossed, (std::vector<uint32_t>{0, 1}));
}

TEST(Marks, IdsThatTheSceneDoesNotHaveAreRefused) {
  const std::vector<scenes::Vec3d> positions{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const std::vector<Element> elements{{0, 1, 2}};
  Marks marks;
  client::Contacts pairs;
  pairs.elements = {{0, 1}};
  EXPECT_THROW(mark_crossings(marks, pairs, elements, positions), client::Error);
  client::FrameOutput output;
  output.vertex_triangle.count = 1;
  output.vertex_triangle.elements = {{3, 0}};
  output.vertex_triangle.stencils = {{3, 0, 1, 2}};
  output.vertex_triangle.weights = {{0.25, 0.25}};
  EXPECT_THROW(mark_contacts(marks, output, {{}, positions}), client::Error);
}

}  // namespace
}  // namespace collided::cli
