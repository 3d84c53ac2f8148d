// FAST against answers known on paper.

#include <algorithm>
#include <cmath>

#include "tests/gpu/backend.hpp"
#include "tests/support/case.hpp"

namespace collided::test {
namespace {

constexpr double kTolerance = 1e-6;
const Positions kFloor{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

Positions shifted(Positions p, const Vec3d& by) {
  for (Vec3d& x : p)
    for (int k = 0; k < 3; ++k) x[k] += by[k];
  return p;
}

// Vertex 3 above (0.25, 0.25) of the floor; the other two far above, over the floor's inside.
Positions spike(double tip_z) { return {{0.25, 0.25, tip_z}, {0.3, 0.2, tip_z + 4}, {0.2, 0.3, tip_z + 4}}; }

Case spike_over_floor(double from, double to) {
  Case c;
  add_mesh(c, {{0, 1, 2}}, kFloor);
  add_mesh(c, {{0, 1, 2}}, spike(from), spike(to));
  return c;
}

// The lowest edge of a blade along x comes down on the highest edge of a blade along y.
Case crossing_blades(double from, double to) {
  Case c;
  add_mesh(c, {{0, 1, 2}}, {{0, -1, 0}, {0, 3, 0}, {0, 0, -5}});
  const Positions blade{{-1, 0, 0}, {1, 0, 0}, {0, 0, 4}};
  add_mesh(c, {{0, 1, 2}}, shifted(blade, {0, 0, from}), shifted(blade, {0, 0, to}));
  return c;
}

SceneSpec fast(Mode mode, Scalar scalar, double thickness = 0) {
  SceneSpec spec = settings(mode, Accuracy::kFast, scalar, thickness);
  spec.fields = spec.fields.with(ContactField::kWeights);
  return spec;
}

size_t index_of(const ContactSet& contacts, std::array<uint32_t, 2> pair) {
  const auto at = std::find(contacts.elements.begin(), contacts.elements.end(), pair);
  return static_cast<size_t>(at - contacts.elements.begin());
}

class NarrowPhase : public OnBackend<::testing::TestWithParam<Scalar>> {};

TEST_P(NarrowPhase, VertexGoesThroughTriangleHalfWay) {
  const FrameResult r = run_case(spike_over_floor(1, -1), fast(Mode::kCcd, GetParam()));
  ASSERT_EQ(r.vertex_triangle.size(), 1u);
  EXPECT_EQ(r.edge_edge.size(), 0u);
  EXPECT_EQ(r.vertex_triangle.elements[0], (std::array<uint32_t, 2>{3, 0}));
  EXPECT_NEAR(r.vertex_triangle.toi[0], 0.5, kTolerance);
  EXPECT_NEAR(r.vertex_triangle.distance[0], 0, kTolerance);
  EXPECT_NEAR(r.vertex_triangle.weights[0][0], 0.25, kTolerance);
  EXPECT_NEAR(r.vertex_triangle.weights[0][1], 0.25, kTolerance);
  EXPECT_EQ(r.vertex_triangle.flags[0] & kFlagInitial, 0);
  EXPECT_EQ(r.earliest_toi, r.vertex_triangle.toi[0]);
}

TEST_P(NarrowPhase, EdgesCrossAtAQuarter) {
  const FrameResult r = run_case(crossing_blades(0.5, -1.5), fast(Mode::kCcd, GetParam()));
  ASSERT_EQ(r.edge_edge.size(), 1u);
  EXPECT_EQ(r.vertex_triangle.size(), 0u);
  EXPECT_NEAR(r.edge_edge.toi[0], 0.25, kTolerance);
  EXPECT_NEAR(r.edge_edge.distance[0], 0, kTolerance);
  EXPECT_NEAR(r.edge_edge.weights[0][0], 0.25, kTolerance);
  EXPECT_NEAR(r.edge_edge.weights[0][1], 0.5, kTolerance);
  EXPECT_NEAR(r.earliest_toi, 0.25, kTolerance);
}

TEST_P(NarrowPhase, NoContactBeforeTheTouch) {
  for (const Case& c : {spike_over_floor(1, 0.1), crossing_blades(1, 0.1)}) {
    const FrameResult r = run_case(c, fast(Mode::kCcd, GetParam()));
    EXPECT_EQ(r.vertex_triangle.size() + r.edge_edge.size(), 0u);
    EXPECT_EQ(r.earliest_toi, 1);
    EXPECT_EQ(r.counts.contacts.vertex_triangle + r.counts.contacts.edge_edge, 0u);
  }
}

TEST_P(NarrowPhase, ContactAtTheStartIsInitial) {
  for (double to : {1.0, -1.0}) {
    const FrameResult r = run_case(spike_over_floor(0, to), fast(Mode::kCcd, GetParam()));
    ASSERT_EQ(r.vertex_triangle.size(), 1u) << to;
    EXPECT_EQ(r.vertex_triangle.toi[0], 0);
    EXPECT_NE(r.vertex_triangle.flags[0] & kFlagInitial, 0);
    EXPECT_EQ(r.earliest_toi, 0);
  }
  const FrameResult r = run_case(crossing_blades(0, 1), fast(Mode::kCcd, GetParam()));
  ASSERT_EQ(r.edge_edge.size(), 1u);
  EXPECT_EQ(r.edge_edge.toi[0], 0);
  EXPECT_NE(r.edge_edge.flags[0] & kFlagInitial, 0);
}

// From guarded on: at the start as far apart as the thickness allows, and not.
TEST_P(NarrowPhase, ContactWithinTheThicknessAtTheStartIsInitial) {
  for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact})
    for (const double from : {0.0625, 1.0}) {
      const FrameResult r = run_case(spike_over_floor(from, -1), settings(Mode::kCcd, accuracy, GetParam(), 0.125));
      ASSERT_EQ(r.vertex_triangle.size(), 1u) << from;
      EXPECT_EQ(r.vertex_triangle.toi[0] == 0, from < 0.125);
      EXPECT_EQ((r.vertex_triangle.flags[0] & kFlagInitial) != 0, from < 0.125);
    }
}

TEST_P(NarrowPhase, ContactAtTheEndCounts) {
  const FrameResult r = run_case(spike_over_floor(1, 0), fast(Mode::kCcd, GetParam()));
  ASSERT_EQ(r.vertex_triangle.size(), 1u);
  EXPECT_NEAR(r.vertex_triangle.toi[0], 1, kTolerance);
}

TEST_P(NarrowPhase, DiscreteDistanceOverTheFace) {
  const FrameResult r = run_case(spike_over_floor(0.0625, 0.0625), fast(Mode::kDcd, GetParam(), 0.1));
  ASSERT_EQ(r.vertex_triangle.size(), 1u);
  EXPECT_EQ(r.edge_edge.size(), 0u);
  EXPECT_NEAR(r.vertex_triangle.distance[0], 0.0625, kTolerance);
  EXPECT_NEAR(r.vertex_triangle.weights[0][0], 0.25, kTolerance);
  EXPECT_NEAR(r.vertex_triangle.weights[0][1], 0.25, kTolerance);
  EXPECT_TRUE(r.vertex_triangle.toi.empty());
  EXPECT_EQ(r.earliest_toi, 1);
}

TEST_P(NarrowPhase, DiscreteBeyondTheThicknessIsNoContact) {
  const FrameResult r = run_case(spike_over_floor(0.11, 0.11), fast(Mode::kDcd, GetParam(), 0.1));
  EXPECT_EQ(r.vertex_triangle.size() + r.edge_edge.size(), 0u);
}

TEST_P(NarrowPhase, DiscreteDistanceToACorner) {
  Case c;
  add_mesh(c, {{0, 1, 2}}, kFloor);
  add_mesh(c, {{0, 1, 2}}, {{-0.03, -0.04, 0}, {-2, -3, 4}, {-3, -2, 4}});
  const FrameResult r = run_case(c, fast(Mode::kDcd, GetParam(), 0.1));
  const size_t at = index_of(r.vertex_triangle, {3, 0});
  ASSERT_LT(at, r.vertex_triangle.size());
  EXPECT_NEAR(r.vertex_triangle.distance[at], 0.05, kTolerance);
  EXPECT_NEAR(r.vertex_triangle.weights[at][0], 0, kTolerance);
  EXPECT_NEAR(r.vertex_triangle.weights[at][1], 0, kTolerance);
}

TEST_P(NarrowPhase, DiscreteDistanceOfCrossingEdges) {
  const FrameResult r = run_case(crossing_blades(0.05, 0.05), fast(Mode::kDcd, GetParam(), 0.1));
  ASSERT_EQ(r.edge_edge.size(), 1u);
  EXPECT_NEAR(r.edge_edge.distance[0], 0.05, kTolerance);
  EXPECT_NEAR(r.edge_edge.weights[0][0], 0.25, kTolerance);
  EXPECT_NEAR(r.edge_edge.weights[0][1], 0.5, kTolerance);
}

TEST_P(NarrowPhase, WeightsComeOnlyIfAskedFor) {
  SceneSpec spec = fast(Mode::kCcd, GetParam());
  spec.fields = spec.fields.without(ContactField::kWeights);
  const FrameResult r = run_case(spike_over_floor(1, -1), spec);
  ASSERT_EQ(r.vertex_triangle.size(), 1u);
  EXPECT_TRUE(r.vertex_triangle.weights.empty());
  EXPECT_EQ(r.vertex_triangle.toi.size(), 1u);
}

TEST_P(NarrowPhase, CandidatesHaveNoNarrowArrays) {
  const FrameResult r = run_case(spike_over_floor(1, -1), settings(Mode::kCcd, Accuracy::kCandidates, GetParam()));
  ASSERT_GE(r.vertex_triangle.size(), 1u);
  EXPECT_TRUE(r.vertex_triangle.toi.empty());
  EXPECT_TRUE(r.vertex_triangle.distance.empty());
  EXPECT_TRUE(r.vertex_triangle.flags.empty());
}

INSTANTIATE_TEST_SUITE_P(Scalars, NarrowPhase, ::testing::Values(Scalar::kF32, Scalar::kF64),
                         [](const auto& info) { return info.param == Scalar::kF32 ? "F32" : "F64"; });

}  // namespace
}  // namespace collided::test
