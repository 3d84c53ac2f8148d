// What is drawn of a scene, whole and thinned.

#include "client/cli/web/surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace collided::cli {
namespace {

using client::MeshElements;
using Triangles = std::vector<std::array<uint32_t, 3>>;

/// A grid of `side` x `side` vertices, closed to a torus: every edge has two triangles.
MeshElements torus(uint32_t side) {
  MeshElements mesh{.vertex_count = side * side, .elements = {}};
  const auto at = [side](uint32_t x, uint32_t y) { return y % side * side + x % side; };
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) {
      mesh.elements.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
      mesh.elements.push_back({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  return mesh;
}

/// The same in a random order of its vertices.
MeshElements shuffled(MeshElements mesh) {
  std::vector<uint32_t> place(mesh.vertex_count);
  for (uint32_t i = 0; i < mesh.vertex_count; ++i) place[i] = i;
  std::shuffle(place.begin(), place.end(), std::mt19937(7));
  for (auto& element : mesh.elements)
    for (uint32_t& vertex : element) vertex = place[vertex];
  return mesh;
}

TEST(Surface, OfAllVerticesHasEveryElement) {
  const MeshElements first{.vertex_count = 3, .elements = {{0, 1, 2}}};
  const MeshElements second{.vertex_count = 6, .elements = {{2, 1, 0}, {4, 3, 3}, {5, 5, 5}}};
  const Surface surface = make_surface({first, second}, 1);
  EXPECT_EQ(surface.triangles, (Triangles{{0, 1, 2}, {5, 4, 3}}));
  EXPECT_EQ(surface.edges, (std::vector<std::array<uint32_t, 2>>{{7, 6}}));
  EXPECT_EQ(surface.points, std::vector<uint32_t>{8});
  EXPECT_EQ(surface.first_vertex, (std::vector<uint32_t>{0, 3, 9}));
  EXPECT_EQ(surface.triangle_count, (std::vector<uint32_t>{1, 1}));
  EXPECT_EQ(surface.scene.element_count(), 4u);
  EXPECT_EQ(surface.scene.element(2), (std::array<uint32_t, 3>{7, 6, 6}));
}

class ThinnedSurface : public ::testing::TestWithParam<uint32_t> {};

// Whatever the order of the vertices, no hole appears.
TEST_P(ThinnedSurface, StaysClosed) {
  constexpr uint32_t kSide = 60;
  for (const MeshElements& mesh : {torus(kSide), shuffled(torus(kSide))}) {
    const Surface surface = make_surface({mesh}, GetParam());
    EXPECT_EQ(surface.vertex_count, (mesh.vertex_count + GetParam() - 1) / GetParam());
    ASSERT_GT(surface.triangles.size(), 0u);
    EXPECT_LT(surface.triangles.size(), mesh.elements.size());
    std::map<std::pair<uint32_t, uint32_t>, int> balance;  // of an edge's two directions, in closed surfaces the same
    for (const auto& [a, b, c] : surface.triangles)
      for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
        ASSERT_LT(from, surface.vertex_count);
        ASSERT_NE(from, to);
        ++balance[{std::min(from, to), std::max(from, to)}];
      }
    EXPECT_TRUE(std::all_of(balance.begin(), balance.end(), [](const auto& edge) { return edge.second >= 2; }));
  }
}

INSTANTIATE_TEST_SUITE_P(Strides, ThinnedSurface, ::testing::Values(2, 3, 7, 50));

TEST(Surface, ThinnedKeepsTheKeptVerticesAndFindsOnesForTheOthers) {
  const MeshElements strip{.vertex_count = 7, .elements = {{0, 1, 2}, {1, 2, 3}, {2, 3, 4}}};  // 5 and 6 are alone
  const Surface surface = make_surface({strip}, 4);
  EXPECT_EQ(surface.vertex_count, 2u);
  EXPECT_EQ(surface.shown_vertex, (std::vector<uint32_t>{0, 0, 0, 1, 1, kNotShown, kNotShown}));
}

TEST(Surface, OfRemovedMeshesIsEmpty) {
  const Surface surface = make_surface({MeshElements{}, MeshElements{.vertex_count = 3, .elements = {{0, 1, 2}}}}, 3);
  EXPECT_EQ(surface.vertex_count, 1u);
  EXPECT_TRUE(surface.triangles.empty());
  EXPECT_EQ(surface.first_vertex, (std::vector<uint32_t>{0, 0, 1}));
}

}  // namespace
}  // namespace collided::cli
