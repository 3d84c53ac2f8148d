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

constexpr std::array<uint32_t, 3> kFirst[] = {{0, 1, 2}}, kBoth[] = {{0, 1, 2}, {3, 4, 5}};

client::SceneFeatures scene_of(std::span<const std::array<uint32_t, 3>> triangles) {
  const client::MeshInput mesh{.vertex_count = 3 * static_cast<uint32_t>(triangles.size()), .triangles = triangles};
  return client::SceneFeatures(std::span(&mesh, 1));
}

TEST(MarkTrianglePairs, NamesTheElementsOfBoth) {
  const std::vector<scenes::Vec3d> positions{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, -1}, {1, 1, 1}, {2, 1, 0}};
  client::Contacts pairs;
  pairs.elements = {{0, 1}};
  Marks marks;
  EXPECT_TRUE(marks.is_empty());
  mark_triangle_pairs(marks, pairs, scene_of(kBoth), positions);
  ASSERT_EQ(marks.crossings.size(), 1u);
  EXPECT_EQ(sorted(marks.crossings[0]), (Segment{{{1, 1, 0}, {2, 1, 0}}}));
  EXPECT_EQ(marks.crossed, (std::vector<uint32_t>{0, 1}));
}

TEST(MarkContours, AreLinesFromCrossingToCrossing) {
  const std::vector<scenes::Vec3d> positions{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, -1}, {1, 1, 1}, {2, 1, 1}};
  client::Contacts crossings;
  crossings.count = 2;
  crossings.elements = {{3, 0}, {4, 0}};
  crossings.weights = {{0.25, 0.25}, {0.375, 0.25}};
  Marks marks;
  mark_contours(marks, crossings, scene_of(kBoth), positions);
  ASSERT_EQ(marks.crossings.size(), 1u);
  EXPECT_EQ(sorted(marks.crossings[0]), (Segment{{{1, 1, 0}, {1.5, 1, 0}}}));
  EXPECT_EQ(marks.crossed, (std::vector<uint32_t>{0, 1, 0, 1}));
}

TEST(Marks, IdsThatTheSceneDoesNotHaveAreRefused) {
  const std::vector<scenes::Vec3d> positions{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const client::SceneFeatures scene = scene_of(kFirst);
  Marks marks;
  client::Contacts pairs;
  pairs.elements = {{0, 1}};
  EXPECT_THROW(mark_triangle_pairs(marks, pairs, scene, positions), client::Error);
  client::Contacts crossings;
  crossings.count = 1, crossings.elements = {{3, 0}}, crossings.weights = {{0, 0}};
  EXPECT_THROW(mark_contours(marks, crossings, scene, positions), client::Error);
  client::FrameOutput output;
  output.vertex_triangle.count = 1;
  output.vertex_triangle.elements = {{3, 0}};
  output.vertex_triangle.stencils = {{3, 0, 1, 2}};
  output.vertex_triangle.weights = {{0.25, 0.25}};
  EXPECT_THROW(mark_contacts(marks, output, {{}, positions}), client::Error);
}

}  // namespace
}  // namespace collided::cli
