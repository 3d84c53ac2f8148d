// Candidates are exactly the pairs of features whose boxes meet: compared with brute force.

#include <random>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/brute_force.hpp"

namespace collided::test {
namespace {

void expect_brute_force(const Case& exact, Mode mode, Scalar scalar, double thickness) {
  SCOPED_TRACE(exact.name + (mode == Mode::kCcd ? " CCD" : " DCD") + (scalar == Scalar::kF32 ? " F32" : " F64"));
  const Case c = rounded(exact, scalar);
  const FrameResult result = run_case(c, settings(mode, Accuracy::kCandidates, scalar, thickness));
  const ExpectedPairs expected = brute_force(c, mode, scalar, thickness);
  EXPECT_EQ("", compare(result.vertex_triangle.elements, expected.vertex_triangle)) << "vertex-triangle";
  EXPECT_EQ("", compare(result.edge_edge.elements, expected.edge_edge)) << "edge-edge";
  EXPECT_EQ(result.counts.candidates.vertex_triangle, result.vertex_triangle.size());
  EXPECT_EQ(result.counts.candidates.edge_edge, result.edge_edge.size());
}

class BroadPhaseScene : public OnBackend<::testing::TestWithParam<std::string>> {};

// One dense cell has a quadratic number of pairs; a coarser scene says as much.
double scale_for(const std::string& scene) { return scene == "one_cell" ? 0.4 : 1; }

// Small beside most of the scene's triangles: brute force knows no better than to test all that are that close.
double thin(const std::string& scene) { return dcd_thickness(scene) / 10; }

struct Look {
  double time;
  std::vector<Scalar> scalars;
};

// Brute force takes seconds on the largest scenes: each scalar is looked at once there.
std::vector<Look> looks_at(const scenes::Scene& scene) {
  if (scene.triangle_count() > 20000) return {{0.2, {Scalar::kF32}}, {0.8, {Scalar::kF64}}};
  std::vector<Look> looks;
  for (const double time : {0.0, 0.2, 0.5, 0.8, 1.0}) looks.push_back({time, {Scalar::kF32, Scalar::kF64}});
  return looks;
}

void expect_scene(const std::string& name, Mode mode, double thickness) {
  const auto scene = scenes::make_scene(name, scale_for(name));
  for (const auto& [t, scalars] : looks_at(*scene)) {
    SCOPED_TRACE(t);
    Case c = case_of(*scene, mode == Mode::kCcd ? std::max(0.0, t - 1.0 / 60) : t, t);
    c.name = name;
    for (Scalar scalar : scalars) expect_brute_force(c, mode, scalar, thickness);
  }
}

TEST_P(BroadPhaseScene, ContinuousEqualsBruteForce) { expect_scene(GetParam(), Mode::kCcd, 0); }
TEST_P(BroadPhaseScene, DiscreteEqualsBruteForce) { expect_scene(GetParam(), Mode::kDcd, thin(GetParam())); }

INSTANTIATE_TEST_SUITE_P(Procedural, BroadPhaseScene, ::testing::ValuesIn(scene_names()),
                         [](const auto& info) { return info.param; });

class BroadPhaseFamily : public OnBackend<::testing::TestWithParam<Case>> {};

TEST_P(BroadPhaseFamily, ContinuousEqualsBruteForce) {
  for (Scalar scalar : {Scalar::kF32, Scalar::kF64}) expect_brute_force(GetParam(), Mode::kCcd, scalar, 0);
}

TEST_P(BroadPhaseFamily, ContinuousWithThicknessEqualsBruteForce) {
  for (Scalar scalar : {Scalar::kF32, Scalar::kF64}) expect_brute_force(GetParam(), Mode::kCcd, scalar, 0.02);
}

TEST_P(BroadPhaseFamily, DiscreteEqualsBruteForce) {
  for (double thickness : {0.0, 0.01})
    for (Scalar scalar : {Scalar::kF32, Scalar::kF64}) expect_brute_force(GetParam(), Mode::kDcd, scalar, thickness);
}

INSTANTIATE_TEST_SUITE_P(Adversarial, BroadPhaseFamily, ::testing::ValuesIn(adversarial_cases()),
                         [](const auto& info) { return info.param.name; });

using BroadPhase = OnBackend<>;

// Coordinates a few steps from a corner, which float cannot tell from each other.
TEST_F(BroadPhase, IsThatOfDoubleWhereFloatIsCoarse) {
  for (const auto [corner, step] : {std::array{1e8, 0.5}, {-0x1p-147, 0x1p-151}, {0x1.fffffcp127, 0x1p102}}) {
    std::mt19937 random(3);
    const auto point = [&] {
      Vec3d p;
      for (double& x : p) x = corner + static_cast<double>(random() % 64) * step;
      return p;
    };
    Case c{"coarse " + std::to_string(corner), {}, {}, {}};
    for (const uint32_t triangles : {8u, 24u}) {
      std::vector<std::array<uint32_t, 3>> ids;
      Positions start, end;
      for (uint32_t t = 0; t < triangles; ++t) {
        ids.push_back({3 * t, 3 * t + 1, 3 * t + 2});
        for (int k = 0; k < 3; ++k) start.push_back(point()), end.push_back(point());
      }
      add_mesh(c, ids, start, end);
    }
    for (const Mode mode : {Mode::kCcd, Mode::kDcd}) expect_brute_force(c, mode, Scalar::kF64, 0);
  }
}

TEST_F(BroadPhase, TopologyIsThatOfTheMeshes) {
  const Case c = case_of("reef_knot", 0.5, Mode::kCcd);
  const auto detector = Detector::create(spec_for(c, settings(Mode::kCcd, Accuracy::kCandidates)));
  const Features expected = features_of(c);
  EXPECT_EQ(detector->topology().triangles, expected.triangles);
  EXPECT_EQ(detector->topology().edges, expected.edges);
  EXPECT_EQ(detector->topology().vertex_count, expected.mesh_of_vertex.size());
  EXPECT_EQ(detector->topology().vertex_offset.size(), c.meshes.size() + 1);
  EXPECT_EQ(detector->topology().triangle_offset.back(), expected.triangles.size());
}

}  // namespace
}  // namespace collided::test
