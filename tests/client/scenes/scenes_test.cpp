// Procedural scenes: exact sizes, same positions every time, nothing out of range.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "client/scenes/formula_scene.hpp"

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

TEST(Scenes, VariantsHaveAsManyTrianglesAsTheSceneTheyVary) {
  const uint64_t expected = make_scene("multiscale_knots")->triangle_count();
  EXPECT_EQ(list_variants().size(), 3u);
  for (const SceneInfo& info : list_variants()) EXPECT_EQ(make_scene(info.name)->triangle_count(), expected);
}

double extent_of_last_mesh(const Scene& scene) {
  const auto positions = scene.positions(0);
  double low = positions.back()[0], high = low;
  for (auto p = positions.end() - scene.meshes().back().vertex_count; p != positions.end(); ++p) {
    low = std::min(low, (*p)[0]);
    high = std::max(high, (*p)[0]);
  }
  return high - low;
}

TEST(Scenes, TheRatioOfKnotsIsThatOfTheName) {
  const double size = extent_of_last_mesh(*make_scene("multiscale_knots_1", 0.2));
  for (const auto& [name, ratio] :
       {std::pair{"multiscale_knots_2", 2.0}, {"multiscale_knots_4", 4.0}, {"multiscale_knots", 8.0}})
    EXPECT_NEAR(size / extent_of_last_mesh(*make_scene(name, 0.2)), std::pow(ratio, 3), 1e-6) << name;
}

// The scales that scene.hpp gives for a million triangles and for ten.
TEST(Scenes, GrowToMillionsOfTriangles) {
  EXPECT_EQ(make_scene("cloth_ball", 3.302)->triangle_count(), 1002260u);
  EXPECT_EQ(make_scene("nbody", 2.57)->triangle_count(), 992590u);
  const auto largest = make_scene("cloth_ball", 10.377);
  EXPECT_EQ(largest->triangle_count(), 9899784u);
  EXPECT_EQ(largest->meshes()[0].vertex_count, 2201u * 2201u);
  EXPECT_EQ(largest->positions(0.5).size(), 4954295u);
}

// Only to within rounding: the last bit of a sine is the C library's.
TEST(Scenes, PositionsStayWhatTheyWere) {
  const std::map<std::string, double> expected = {
      {"funnel", -792184.12357946904},       {"cloth_ball", -758653.86146052845},
      {"flamenco", 662683.64102157496},      {"nbody", -277666.20392677153},
      {"reef_knot", 1955.9796353001975},     {"multiscale_knots", 2678375.2950885003},
      {"graded_sheets", 2238993.4915937716}, {"touching_boxes", 12210054.20000001},
      {"one_cell", 167.55231318056852},      {"huge_triangle", 114.09259973508691},
      {"anisotropic", 570951.02906205214}};
  for (const auto& [name, sum] : expected) {
    double found = 0;
    size_t i = 0;
    for (const Vec3d& p : make_scene(name)->positions(0.8))
      for (const double x : p) found += x * double(i++ % 97);
    EXPECT_NEAR(found, sum, 1e-12 * double(i)) << name;
  }
}

TEST(Scenes, ThreadsDoNotChangePositions) {
  const auto formula = [](Param p, double t) -> Vec3d { return {std::sin(p[0] + t), std::cos(p[1] * t), p[0] * p[1]}; };
  std::vector<Part> parts{grid("first", {0, 3, 150}, {0, 5, 100}), grid("second", {1, 2, 3}, {3, 4, 5})};
  std::vector<Vec3d> expected;
  for (Part& part : parts) {
    part.formula = formula;
    for (const Param& p : part.params) expected.push_back(formula(p, 0.3));
  }
  EXPECT_EQ(FormulaScene(std::move(parts)).positions(0.3), expected);
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
  for (const auto& list : {list_scenes(), list_variants()})
    for (const SceneInfo& info : list) out.push_back(info.name);
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
