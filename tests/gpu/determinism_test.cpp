// The same bytes for any number of threads and on every backend.

#include "tests/gpu/backend.hpp"
#include "tests/support/case.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

double scale_for(const std::string& scene) { return scene == "one_cell" ? 0.4 : 1; }

FrameResult run_with(const Case& c, SceneSpec spec, Backend backend, int threads) {
  spec.backend = backend;
  spec.threads = threads;
  return run_case(c, spec);
}

void expect_same_everywhere(const std::string& name, Mode mode, Scalar scalar, double thickness) {
  const auto scene = scenes::make_scene(name, scale_for(name));
  const Case c = case_of(*scene, mode == Mode::kCcd ? 0.8 - 1.0 / 60 : 0.8, 0.8);
  SceneSpec spec = settings(mode, Accuracy::kFast, scalar, thickness);
  spec.weights = true;
  const FrameResult one = run_with(c, spec, Backend::kCpu, 1);
  const FrameResult other = run_with(c, spec, kBackend, 2);
  EXPECT_TRUE(same_bytes(one.vertex_triangle, other.vertex_triangle))
      << one.vertex_triangle.size() << " against " << other.vertex_triangle.size();
  EXPECT_TRUE(same_bytes(one.edge_edge, other.edge_edge))
      << one.edge_edge.size() << " against " << other.edge_edge.size();
  EXPECT_EQ(one.earliest_toi, other.earliest_toi);
  EXPECT_EQ(one.counts.tests, other.counts.tests);
  EXPECT_EQ(one.counts.pairs, other.counts.pairs);
}

class Determinism : public OnBackend<::testing::TestWithParam<std::string>> {};

TEST_P(Determinism, Continuous) { expect_same_everywhere(GetParam(), Mode::kCcd, Scalar::kF32, 0); }
TEST_P(Determinism, ContinuousDouble) { expect_same_everywhere(GetParam(), Mode::kCcd, Scalar::kF64, 0); }
TEST_P(Determinism, Discrete) {
  expect_same_everywhere(GetParam(), Mode::kDcd, Scalar::kF32, dcd_thickness(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Procedural, Determinism, ::testing::ValuesIn(scene_names()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace collided::test
