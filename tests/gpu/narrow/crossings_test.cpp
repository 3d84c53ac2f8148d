// Edges that go through triangles, against rationals: all of them, at every level, with neighbours.

#include <algorithm>
#include <cmath>
#include <optional>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/narrow/crossing_judge.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

constexpr Accuracy kDecidingLevels[] = {Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact};

SceneSpec crossings_alone(Accuracy accuracy = Accuracy::kCertified, Scalar scalar = Scalar::kF64) {
  SceneSpec spec = settings(Mode::kDcd, accuracy, scalar);
  spec.kinds = {.edge_triangle = true};
  spec.fields = {ContactField::kElements, ContactField::kWeights, ContactField::kFlags};
  return spec;
}

void expect_points_on_both(const ContactSet& found, const Surface& surface, double slack) {
  for (size_t i = 0; i < found.size(); ++i) {
    const auto [u, v] = surface.topology.edges[found.elements[i][0]];
    const auto& ids = surface.topology.triangles[found.elements[i][1]];
    const auto [w1, w2] = found.weights[i];
    EXPECT_TRUE(w1 >= 0 && w2 >= 0 && w1 + w2 <= 1 + slack) << w1 << " " << w2;
    Vec3d p, along;
    double length = 0, at = 0, off = 0;
    for (size_t k = 0; k < 3; ++k) {
      const auto of = [&](uint32_t id) { return surface.positions[id][k]; };
      p[k] = (1 - w1 - w2) * of(ids[0]) + w1 * of(ids[1]) + w2 * of(ids[2]) - of(u);
      along[k] = of(v) - of(u);
      length += along[k] * along[k], at += along[k] * p[k];
    }
    const double share = length > 0 ? std::clamp(at / length, 0.0, 1.0) : 0;
    for (size_t k = 0; k < 3; ++k) off += (p[k] - share * along[k]) * (p[k] - share * along[k]);
    EXPECT_LE(std::sqrt(off), slack) << "contact " << i;
  }
}

void expect_judged(const Case& c, Scalar scalar, size_t least) {
  const Surface surface(c);
  const JudgedCrossings judged = judge_crossings(surface);
  EXPECT_GE(judged.sure.size(), least) << "the case tells nothing";
  const std::vector<PairKey> all = judged.all();
  std::optional<FrameResult> before;
  for (const Accuracy accuracy : kDecidingLevels) {
    SCOPED_TRACE(level_name(accuracy));
    FrameResult r = run_case(c, crossings_alone(accuracy, scalar));
    const ContactSet& found = r.edge_triangle;
    EXPECT_EQ(keys_of(found), all);
    EXPECT_EQ(r.counts.contacts.edge_triangle, all.size());
    for (size_t i = 0; i < found.size(); ++i) {
      const bool is_tied = std::ranges::binary_search(judged.tied, keys_of(found)[i]);
      EXPECT_EQ(found.flags[i], is_tied ? kFlagCertified | kFlagTouching : kFlagCertified);
    }
    EXPECT_TRUE(all.empty() || r.any_contact);
    EXPECT_TRUE(found.toi.empty() && found.distance.empty() && found.normals.empty());
    expect_points_on_both(found, surface, scalar == Scalar::kF32 ? 1e-4 : 1e-11);
    if (before) {
      EXPECT_TRUE(same_bytes(found, before->edge_triangle));
    }
    before = std::move(r);
  }
}

class Crossings : public OnBackend<::testing::TestWithParam<Scalar>> {};

TEST_P(Crossings, OfRandomSoups) {
  expect_judged(rounded(soup(210, 200, 1, 0.3, 0.1), GetParam()), GetParam(), 100);
  expect_judged(rounded(loose_soup(211, 200, 1, 0.3, 0.1), GetParam()), GetParam(), 50);
  expect_judged(rounded(soup(212, 200, 1, 0.3, 0.1, {1e3, 2e3, -3e3}), GetParam()), GetParam(), 100);
}

TEST_P(Crossings, OfASheetWithItself) {
  expect_judged(rounded(crumpled(213, 12, 0.1), GetParam()), GetParam(), 0);
  expect_judged(rounded(crumpled(214, 12, 0.9), GetParam()), GetParam(), 80);
  expect_judged(rounded(crumpled(215, 12, 1.5), GetParam()), GetParam(), 300);
}

// Vertices on triangles, edges in planes, edges that meet edges, what is there twice.
TEST_P(Crossings, OfLattices) {
  expect_judged(lattice(216, 80, 3), GetParam(), 100);
  Case flat = lattice(217, 80, 6);
  for (Vec3d& p : flat.end[0]) p[2] = p[0] - p[1];
  expect_judged(flat, GetParam(), 0);
  Case rough = crumpled(218, 12, 1.5);
  for (Vec3d& p : rough.end[0])
    for (double& x : p) x = std::round(x);
  expect_judged(rough, GetParam(), 80);
}

INSTANTIATE_TEST_SUITE_P(Scalars, Crossings, ::testing::Values(Scalar::kF32, Scalar::kF64),
                         [](const auto& info) { return info.param == Scalar::kF32 ? "F32" : "F64"; });

using CrossingRules = OnBackend<>;

TEST_F(CrossingRules, AFlatSheetHasNone) {
  const FrameResult r = run_case(crumpled(1, 30, 0), crossings_alone());
  EXPECT_EQ(r.edge_triangle.size(), 0u);
  EXPECT_FALSE(r.any_contact);
  EXPECT_EQ(r.counts.exact_decisions, 0u) << "each is a look of the host's";
}

// The acceptance case of two triangles with a common corner: the far side of one pierces the other.
TEST_F(CrossingRules, NeighboursCross) {
  Case c;
  add_mesh(c, {{0, 1, 2}, {0, 3, 4}}, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {2, 1, -1}, {2, 1.5, 2}});
  FrameResult r = run_case(c, crossings_alone());
  ASSERT_EQ(r.edge_triangle.size(), 1u);
  EXPECT_EQ(r.edge_triangle.elements[0][1], 0u);
  EXPECT_NEAR(r.edge_triangle.weights[0][0], 2.0 / 4, 1e-15);
  EXPECT_NEAR(r.edge_triangle.weights[0][1], 7.0 / 6 / 4, 1e-15);
  c.meshes[0].excluded_rings = 1;
  EXPECT_EQ(run_case(c, crossings_alone()).edge_triangle.size(), 0u);
}

// What touches is told by any_contact, though the order of ids may make it no crossing.
TEST_F(CrossingRules, ATouchIsAContact) {
  size_t crossings = 0;
  for (const bool is_swapped : {false, true}) {
    const std::vector<std::array<uint32_t, 3>> one{{0, 1, 2}};
    const Positions floor{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, above{{1, 1, 0}, {1, 1, 1}, {1.5, 1, 1}};
    Case c;
    add_mesh(c, one, is_swapped ? above : floor);
    add_mesh(c, one, is_swapped ? floor : above);
    for (const Report report : {Report::kAll, Report::kAnyHit}) {
      SceneSpec spec = crossings_alone();
      spec.report = report;
      const FrameResult r = run_case(c, spec);
      EXPECT_TRUE(r.any_contact);
      crossings += r.edge_triangle.size();
      for (const uint8_t flags : r.edge_triangle.flags) EXPECT_EQ(flags, kFlagCertified | kFlagTouching);
    }
  }
  EXPECT_EQ(crossings % 2, 0u) << "of a corner both sides cross, or neither";
}

TEST_F(CrossingRules, AnyHitTellsWhetherThereIsOne) {
  SceneSpec spec = crossings_alone();
  spec.report = Report::kAnyHit;
  EXPECT_TRUE(run_case(crumpled(2, 20, 1.2), spec).any_contact);
  EXPECT_FALSE(run_case(crumpled(2, 20, 0.05), spec).any_contact);
  spec.kinds.vertex_triangle = spec.kinds.edge_edge = spec.kinds.triangle_triangle = true;
  EXPECT_TRUE(run_case(crumpled(2, 20, 1.2), spec).any_contact);
}

// With the other kinds they are the same, and the other kinds are what they are without.
TEST_F(CrossingRules, KindsDoNotDisturbEachOther) {
  const Case c = crumpled(3, 16, 1);
  for (const Accuracy accuracy : kDecidingLevels) {
    SceneSpec spec = settings(Mode::kDcd, accuracy, Scalar::kF64, 0.01);
    spec.kinds.triangle_triangle = true;
    const FrameResult others = run_case(c, spec);
    spec.kinds.edge_triangle = true;
    const FrameResult all = run_case(c, spec);
    EXPECT_TRUE(same_contacts(others, all));
    EXPECT_TRUE(same_bytes(others.triangle_triangle, all.triangle_triangle));
    EXPECT_GT(all.edge_triangle.size(), 100u);
    EXPECT_EQ(keys_of(all.edge_triangle), keys_of(run_case(c, crossings_alone(accuracy)).edge_triangle));
  }
}

TEST_F(CrossingRules, AreTheSameForEachEngineAndInShards) {
  const Case c = crumpled(4, 24, 1.2);
  const FrameResult expected = run_case(c, crossings_alone());
  EXPECT_GT(expected.edge_triangle.size(), 500u);
  for (const Engine engine :
       {Engine::kOctree, Engine::kTopDown, Engine::kUniformGrid, Engine::kLbvh, Engine::kVss, Engine::kAllPairs}) {
    SceneSpec spec = crossings_alone();
    spec.engine = engine;
    EXPECT_TRUE(same_bytes(run_case(c, spec).edge_triangle, expected.edge_triangle)) << static_cast<int>(engine);
  }
  for (const int threads : {1, 3}) {
    SceneSpec spec = crossings_alone();
    spec.threads = threads;
    EXPECT_TRUE(same_bytes(run_case(c, spec).edge_triangle, expected.edge_triangle)) << threads;
  }
}

// Scenes of both modes have crossings in frames of DCD alone.
TEST_F(CrossingRules, AreOfDiscreteFrames) {
  const Case c = crumpled(5, 12, 1);
  SceneSpec spec = crossings_alone();
  spec.mode = Mode::kBoth;
  spec.kinds.vertex_triangle = spec.kinds.edge_edge = true;
  const auto detector = Detector::create(spec_for(c, spec));
  const Frame first(c, Mode::kCcd, Scalar::kF64);
  FrameInput input = first.input();
  const FrameResult moving = detector->detect(input);
  EXPECT_EQ(moving.edge_triangle.size(), 0u);
  FrameInput still;
  still.mode = Mode::kDcd;
  EXPECT_EQ(keys_of(detector->detect(still).edge_triangle), keys_of(run_case(c, crossings_alone()).edge_triangle));
}

TEST_F(CrossingRules, WhatCannotBeIsRefused) {
  const Case c = crumpled(6, 2, 1);
  const auto refused = [&](SceneSpec spec) { return refused_field([&] { Detector::create(spec_for(c, spec)); }); };
  SceneSpec spec = crossings_alone();
  spec.mode = Mode::kCcd;
  EXPECT_EQ(refused(spec), "edge_triangle");
  spec.mode = Mode::kBoth;
  EXPECT_EQ(refused(spec), "kinds");
  EXPECT_EQ(refused(crossings_alone(Accuracy::kCandidates)), "edge_triangle");
  spec = crossings_alone(Accuracy::kCertified, Scalar::kF32);
  spec.quantized_in = PositionBox{{-10, -10, -10}, {30, 30, 30}};
  EXPECT_EQ(refused(spec), "edge_triangle");
}

}  // namespace
}  // namespace collided::test
