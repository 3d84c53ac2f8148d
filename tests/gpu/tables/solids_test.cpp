// Tests which meshes pass as solids, and how the others are refused.

#include "gpu/tables/solids.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace collided::test {
namespace {

const std::vector<std::array<uint32_t, 3>> kBox = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                                   {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

MeshSpec box() { return {.vertex_count = 8, .triangles = kBox, .solid = true}; }

/// Returns the message; "" if the mesh passes.
std::string refusal(const MeshSpec& mesh) {
  try {
    check_solid(mesh, "meshes[0]");
  } catch (const InvalidInput& e) {
    EXPECT_EQ(e.field(), "meshes[0].solid");
    return e.what();
  }
  return "";
}

TEST(Solids, AreTheMeshesThatSaySo) {
  SceneSpec spec;
  spec.meshes = {box(), MeshSpec{}, box()};
  EXPECT_EQ(solid_meshes(spec), (std::vector<uint32_t>{0, 2}));
}

TEST(Solids, PassIfBalanced) {
  EXPECT_EQ(refusal(box()), "");
  MeshSpec touching = box();  // two boxes with a common edge 0-1, which then has four triangles
  for (auto t : kBox) {
    for (uint32_t& v : t) v = v == 0 ? 0 : v == 1 ? 1 : v + 8;
    touching.triangles.push_back(t);
  }
  EXPECT_EQ(refusal(touching), "");
  MeshSpec twice = box();
  twice.triangles.insert(twice.triangles.end(), kBox.begin(), kBox.end());
  EXPECT_EQ(refusal(twice), "");
  MeshSpec inside_out = box();  // the volume is for others to check
  for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
  EXPECT_EQ(refusal(inside_out), "");
}

TEST(Solids, HaveTrianglesAlone) {
  MeshSpec mesh = box();
  mesh.edges = {{0, 7}, {1, 6}};
  EXPECT_EQ(refusal(mesh), "meshes[0].solid is on, but the mesh has 2 loose edges: a solid is of triangles alone");
  mesh.edges.clear();
  mesh.points = {3};
  EXPECT_EQ(refusal(mesh), "meshes[0].solid is on, but the mesh has 1 loose point: a solid is of triangles alone");
}

TEST(Solids, HaveNoHoles) {
  MeshSpec mesh = box();
  mesh.triangles.erase(mesh.triangles.begin() + 7);  // 2 7 3
  EXPECT_EQ(refusal(mesh), "meshes[0].solid is on, but edge 2-3 has 1 triangle: the mesh is open");
}

TEST(Solids, HaveEdgesOfBothDirections) {
  MeshSpec turned = box();
  std::swap(turned.triangles[7][0], turned.triangles[7][1]);
  EXPECT_EQ(refusal(turned), "meshes[0].solid is on, but edge 2-3 has 2 triangles in one direction and 0 in the other");
  MeshSpec odd = box();
  odd.vertex_count = 13;
  odd.triangles.push_back({12, 3, 2});
  EXPECT_EQ(refusal(odd), "meshes[0].solid is on, but edge 2-3 has 2 triangles in one direction and 1 in the other");
}

TEST(Solids, HaveNoFins) {
  MeshSpec mesh = box();
  mesh.vertex_count = 11;
  mesh.triangles.insert(mesh.triangles.begin() + 3, {8, 9, 10});
  mesh.triangles.insert(mesh.triangles.begin() + 9, {9, 8, 10});
  EXPECT_EQ(refusal(mesh),
            "meshes[0].solid is on, but triangle 9 is the reverse of triangle 3: there is no volume between them");
  for (auto t : kBox) mesh.triangles.push_back({t[1], t[0], t[2]});  // reverses of triangle 0 and all others
  EXPECT_EQ(refusal(mesh),
            "meshes[0].solid is on, but triangle 14 is the reverse of triangle 0: there is no volume between them");
}

/// Names the lowest edge and the lowest triangles by brute force, on random triangles of few vertices.
TEST(Solids, AreRefusedForTheFirstReason) {
  std::mt19937 random(1);
  int fins = 0, edges = 0;
  for (int i = 0; i < 3000; ++i) {
    MeshSpec mesh{.vertex_count = 5, .solid = true};
    for (int k = 0; k < 4; ++k) {
      std::array<uint32_t, 5> v = {0, 1, 2, 3, 4};
      std::shuffle(v.begin(), v.end(), random);
      mesh.triangles.push_back({v[0], v[1], v[2]});
      if (i % 2 == 0) mesh.triangles.push_back({v[2], v[1], v[0]});
    }
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
    std::string expected;
    for (uint32_t a = 0; a < 5; ++a)
      for (uint32_t b = a + 1; b < 5; ++b) {
        int balance = 0;
        for (const auto& t : mesh.triangles)
          for (size_t k = 0; k < 3; ++k)
            balance += (t[k] == a && t[(k + 1) % 3] == b) - (t[k] == b && t[(k + 1) % 3] == a);
        if (balance != 0 && expected.empty())
          expected = "edge " + std::to_string(a) + '-' + std::to_string(b) + " has ";
      }
    edges += !expected.empty();
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
      for (size_t u = t + 1; u < mesh.triangles.size() && expected.empty(); ++u) {
        const auto &x = mesh.triangles[t], &y = mesh.triangles[u];
        for (size_t k = 0; k < 3; ++k)
          if (x[0] == y[k] && x[1] == y[(k + 2) % 3] && x[2] == y[(k + 1) % 3])
            expected = "triangle " + std::to_string(u) + " is the reverse of triangle " + std::to_string(t) + ':';
      }
    fins += expected.find("reverse") != std::string::npos;
    ASSERT_EQ(refusal(mesh).empty(), expected.empty());
    ASSERT_NE(refusal(mesh).find(expected), std::string::npos) << refusal(mesh) << '\n' << expected;
  }
  EXPECT_GT(fins, 1000);
  EXPECT_GT(edges, 1000);
}

}  // namespace
}  // namespace collided::test
