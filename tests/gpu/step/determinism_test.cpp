// The same bytes for any number of threads and on every backend.

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

double scale_for(const std::string& scene) { return scene == "one_cell" ? 0.4 : 1; }

FrameResult run_with(const Case& c, SceneSpec spec, Backend backend, int threads) {
  spec.device.backend = backend;
  spec.threads = threads;
  return run_case(c, spec);
}

void expect_same_contacts(const FrameResult& one, const FrameResult& other) {
  EXPECT_TRUE(same_bytes(one.vertex_triangle, other.vertex_triangle))
      << one.vertex_triangle.size() << " against " << other.vertex_triangle.size();
  EXPECT_TRUE(same_bytes(one.edge_edge, other.edge_edge))
      << one.edge_edge.size() << " against " << other.edge_edge.size();
  EXPECT_TRUE(same_bytes(one.triangle_triangle, other.triangle_triangle))
      << one.triangle_triangle.size() << " against " << other.triangle_triangle.size();
  EXPECT_EQ(one.earliest_toi, other.earliest_toi);
  EXPECT_EQ(one.any_contact, other.any_contact);
}

void expect_same(const FrameResult& one, const FrameResult& other) {
  expect_same_contacts(one, other);
  EXPECT_EQ(one.counts.tests, other.counts.tests);
  EXPECT_EQ(one.counts.pairs, other.counts.pairs);
  EXPECT_EQ(one.counts.survivors.vertex_triangle, other.counts.survivors.vertex_triangle);
  EXPECT_EQ(one.counts.survivors.edge_edge, other.counts.survivors.edge_edge);
  EXPECT_EQ(one.counts.exact_decisions, other.counts.exact_decisions);
}

void expect_same_everywhere(const std::string& name, Mode mode, Scalar scalar, double thickness) {
  const auto scene = scenes::make_scene(name, scale_for(name));
  const Case c = case_of(*scene, mode == Mode::kCcd ? 0.8 - 1.0 / 60 : 0.8, 0.8);
  SceneSpec spec = settings(mode, Accuracy::kFast, scalar, thickness);
  spec.fields = spec.fields.with(ContactField::kWeights);
  expect_same(run_with(c, spec, Backend::kCpu, 1), run_with(c, spec, kBackend, 2));
}

class Determinism : public OnBackend<::testing::TestWithParam<std::string>> {};

TEST_P(Determinism, Continuous) { expect_same_everywhere(GetParam(), Mode::kCcd, Scalar::kF32, 0); }
TEST_P(Determinism, ContinuousDouble) { expect_same_everywhere(GetParam(), Mode::kCcd, Scalar::kF64, 0); }
TEST_P(Determinism, Discrete) {
  expect_same_everywhere(GetParam(), Mode::kDcd, Scalar::kF32, dcd_thickness(GetParam()) / 10);
}

INSTANTIATE_TEST_SUITE_P(Procedural, Determinism, ::testing::ValuesIn(scene_names()),
                         [](const auto& info) { return info.param; });

// Moving and static meshes, random and exactly touching features.
Case mixed_case() {
  Case c = soup(130, 400, 6, 1, 0.5);
  const Case wall = soup(131, 100, 6, 1, 0), integers = lattice(132, 60, 8);
  add_mesh(c, wall.meshes[0].triangles, wall.start[0], {}, true);
  add_mesh(c, integers.meshes[0].triangles, integers.start[0], integers.end[0]);
  return c;
}

class DeterminismOfLevels : public OnBackend<::testing::TestWithParam<Accuracy>> {
 protected:
  // With one thread, with two, and with two again.
  static void expect_same_runs(const SceneSpec& spec) {
    for (const Case& c : {mixed_case(), loosened(mixed_case())}) expect_same_runs(c, spec);
  }
  static void expect_same_runs(const Case& c, const SceneSpec& spec) {
    const FrameResult one = run_with(c, spec, Backend::kCpu, 1);
    for (int run = 0; run < 3; ++run) {
      const FrameResult other = run_with(c, spec, kBackend, 2);
      // How much ANY_HIT looks at before it has a contact depends on the order of the threads.
      spec.report == Report::kAnyHit ? expect_same_contacts(one, other) : expect_same(one, other);
    }
  }
};

TEST_P(DeterminismOfLevels, Continuous) {
  for (Scalar scalar : {Scalar::kF32, Scalar::kF64})
    for (Report report : {Report::kAll, Report::kEarliestOnly, Report::kAnyHit})
      for (double delta : {0.0, 0.05}) {
        SceneSpec spec = settings(Mode::kCcd, GetParam(), scalar);
        spec.fields = spec.fields.with(ContactField::kWeights);
        spec.report = report;
        spec.delta = delta;
        expect_same_runs(spec);
      }
}

TEST_P(DeterminismOfLevels, Discrete) {
  for (Scalar scalar : {Scalar::kF32, Scalar::kF64}) {
    SceneSpec spec = settings(Mode::kDcd, GetParam(), scalar, 0x1p-5);
    spec.fields = spec.fields.with(ContactField::kWeights);
    spec.kinds.triangle_triangle = true;
    expect_same_runs(spec);
  }
}

INSTANTIATE_TEST_SUITE_P(Levels, DeterminismOfLevels,
                         ::testing::Values(Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact),
                         [](const auto& info) { return level_name(info.param); });

}  // namespace
}  // namespace collided::test
