// Procedural scenes: exact sizes, same positions every time, nothing out of range.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "client/scenes/scene.hpp"

namespace collided::scenes {
namespace {

TEST(Scenes, TriangleCountsAreThoseOfTheDocumentation) {
  const std::map<std::string, uint64_t> expected = {
      {"funnel", 18504},    {"cloth_ball", 91872},       {"flamenco", 48960},       {"nbody", 146000},
      {"reef_knot", 19992}, {"multiscale_knots", 79968}, {"graded_sheets", 180000}, {"touching_boxes", 20736},
      {"one_cell", 4004},   {"huge_triangle", 20001},    {"anisotropic", 4000}};
  EXPECT_EQ(list_scenes().size(), expected.size());
  for (const auto& [name, count] : expected) EXPECT_EQ(make_scene(name)->triangle_count(), count) << name;
}

class EveryScene : public testing::TestWithParam<std::string> {};

TEST_P(EveryScene, IsSoundAtEveryTime) {
  for (const double scale : {0.1, 1.0}) {
    const auto scene = make_scene(GetParam(), scale);
    uint64_t vertices = 0;
    std::set<std::string> names;
    for (const Mesh& mesh : scene->meshes()) {
      vertices += mesh.vertex_count;
      EXPECT_TRUE(names.insert(mesh.name).second) << mesh.name;
      EXPECT_GE(mesh.vertex_count, 3u);
      for (const auto& t : mesh.triangles) {
        for (const uint32_t v : t) ASSERT_LT(v, mesh.vertex_count);
        ASSERT_TRUE(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
      }
    }
    for (const double t : {0.0, 0.3, 1.0}) {
      const auto positions = scene->positions(t);
      ASSERT_EQ(positions.size(), vertices);
      for (const Vec3d& p : positions)
        for (const double x : p) ASSERT_TRUE(std::isfinite(x) && std::abs(x) < 100);
    }
  }
}

TEST_P(EveryScene, IsDeterministicAndItsStaticMeshesStandStill) {
  const auto a = make_scene(GetParam(), 0.2), b = make_scene(GetParam(), 0.2);
  EXPECT_EQ(a->positions(0.7), b->positions(0.7));
  EXPECT_EQ(a->positions(0.7), a->positions(0.7));
  const auto p0 = a->positions(0), p1 = a->positions(1);
  EXPECT_NE(p0, p1);
  size_t at = 0;
  for (const Mesh& mesh : a->meshes()) {
    for (size_t v = at; mesh.is_static && v < at + mesh.vertex_count; ++v) ASSERT_EQ(p0[v], p1[v]) << mesh.name;
    at += mesh.vertex_count;
  }
}

TEST_P(EveryScene, RefinesWithScale) {
  const double ratio =
      double(make_scene(GetParam(), 2)->triangle_count()) / double(make_scene(GetParam())->triangle_count());
  EXPECT_NEAR(ratio, 4, 0.6);
}

std::vector<std::string> names() {
  std::vector<std::string> out;
  for (const SceneInfo& info : list_scenes()) out.push_back(info.name);
  return out;
}

INSTANTIATE_TEST_SUITE_P(All, EveryScene, testing::ValuesIn(names()), [](const auto& info) { return info.param; });

TEST(Scenes, BadNamesAndScalesAreRefused) {
  EXPECT_THROW(make_scene("nothing"), std::invalid_argument);
  EXPECT_THROW(make_scene("funnel", 0), std::invalid_argument);
  EXPECT_THROW(make_scene("funnel", std::nan("")), std::invalid_argument);
  EXPECT_THROW(make_scene("funnel", 1e9), std::invalid_argument);
  EXPECT_THROW(check_scene("nothing", 1), std::invalid_argument);
  EXPECT_THROW(check_scene("funnel", 1e9), std::invalid_argument);
  EXPECT_NO_THROW(check_scene("funnel", 1));
}

}  // namespace
}  // namespace collided::scenes
