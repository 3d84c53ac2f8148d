// What is told of solids, row by row of the table of contacts; each test is named by its row.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/gpu/solid_shapes.hpp"

namespace collided::test {
namespace {

constexpr std::array kLevels = {Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact};

SceneSpec looking(Accuracy accuracy = Accuracy::kExact, Scalar scalar = Scalar::kF64) {
  SceneSpec spec = settings(Mode::kDcd, accuracy, scalar);
  spec.kinds = {.vertex_solid = true};
  spec.fields = {ContactField::kElements, ContactField::kDistance, ContactField::kWeights, ContactField::kNormals,
                 ContactField::kFlags};
  spec.pair_states = true;
  return spec;
}
Case solids(Case c) {
  for (MeshSpec& mesh : c.meshes) mesh.solid = true;
  return c;
}
Case solids(const std::vector<Shape>& shapes) { return solids(apart(shapes)); }

/// The only pair's state; none if there is no pair.
std::optional<MeshPairState> state_of(const Case& c, const SceneSpec& spec = looking()) {
  const FrameResult result = run_case(c, spec);
  EXPECT_LE(result.pair_states.size(), 1u);
  return result.pair_states.empty() ? std::nullopt : std::optional(result.pair_states[0]);
}

/// What a row of two solids is to tell: how many vertices of each are in the other, and how deep the deepest is.
struct Expected {
  const char* row;
  std::optional<PairState> state;
  uint32_t first_inside = 0, second_inside = 0;
  double depth = 0;
};
const Expected kExpected[] = {{"1", PairState::kTouching},
                              {"2", PairState::kOverlapping},
                              {"3", std::nullopt},
                              {"4", PairState::kOverlapping, 0, 4, 0.1},
                              {"5", PairState::kOverlapping},
                              {"6", PairState::kOverlapping},
                              {"7", PairState::kSecondInside, 0, 8, 5},
                              {"8", PairState::kOverlapping},
                              {"9", PairState::kOverlapping},
                              {"10", PairState::kOverlapping},
                              {"11a", PairState::kTouching},
                              {"11b", PairState::kTouching},
                              {"12", PairState::kOverlapping, 2, 0, 0.25}};
const Expected& expected_of(const std::string& row) {
  return *std::ranges::find_if(kExpected, [&](const Expected& expected) { return expected.row == row; });
}

void expect_row(const std::optional<MeshPairState>& found, const Expected& expected, bool is_swapped, double scale,
                double tolerance) {
  ASSERT_EQ(found.has_value(), expected.state.has_value());
  if (!found) return;
  PairState state = *expected.state;
  if (is_swapped && state == PairState::kSecondInside) state = PairState::kFirstInside;
  EXPECT_EQ(found->state, state);
  EXPECT_EQ(is_swapped ? found->second_inside : found->first_inside, expected.first_inside);
  EXPECT_EQ(is_swapped ? found->first_inside : found->second_inside, expected.second_inside);
  EXPECT_NEAR(found->depth / scale, expected.depth, tolerance);
  EXPECT_EQ(found->deepest == MeshPairState::kNoVertex, expected.first_inside + expected.second_inside == 0);
}

using SolidsTable = OnBackend<>;

TEST_F(SolidsTable, Rows1To12AtEveryLevel) {
  for (const Row& row : pairs_of_solids())
    for (const Accuracy accuracy : kLevels)
      for (const Scalar scalar : {Scalar::kF64, Scalar::kF32}) {
        SCOPED_TRACE(row.name + " " + level_name(accuracy) + (scalar == Scalar::kF32 ? " F32" : " F64"));
        const Case c = solids(row.input);
        expect_row(state_of(c, looking(accuracy, scalar)), expected_of(row.name), false, 1,
                   scalar == Scalar::kF32 ? 1e-7 : 1e-15);
      }
}

TEST_F(SolidsTable, Row7DepthsAndNormals) {
  const FrameResult r = run_case(solids(pairs_of_solids()[6].input), looking());
  ASSERT_EQ(r.vertex_solid.size(), 8u);
  EXPECT_TRUE(r.any_contact);
  EXPECT_EQ(r.counts.contacts.vertex_solid, 8u);
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(r.vertex_solid.elements[i][0], 8 + i);
    EXPECT_EQ(r.vertex_solid.distance[i], i == 7 ? -5 : -4);
    EXPECT_EQ(r.vertex_solid.flags[i], kFlagCertified);
    const Normal& n = r.vertex_solid.normals[i];
    EXPECT_EQ(std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]), 1);
    const uint32_t lower = (i & 1 ? n[0] : -n[0]) + (i & 2 ? n[1] : -n[1]) + (i & 4 ? n[2] : -n[2]) > 0 ? 1 : 0;
    EXPECT_TRUE(lower == 1 || i == 7) << i;  // the way out is through the faces that are near
  }
  EXPECT_EQ(r.pair_states[0].deepest, 15u);
}

TEST_F(SolidsTable, Row4NearestTriangleAndWeights) {
  const FrameResult r = run_case(solids(pairs_of_solids()[3].input), looking());
  ASSERT_EQ(r.vertex_solid.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(r.vertex_solid.distance[i], -0.1, 1e-16);
    EXPECT_EQ(r.vertex_solid.normals[i], (Normal{0, 0, 1}));
    EXPECT_TRUE(r.vertex_solid.elements[i][1] == 2 || r.vertex_solid.elements[i][1] == 3);  // the top
    const auto [w1, w2] = r.vertex_solid.weights[i];
    EXPECT_GE(std::min({w1, w2, 1 - w1 - w2}), 0);
  }
}

TEST_F(SolidsTable, Row13Cavities) {
  const Shape hollow = together(box({0, 0, 0}, {4, 4, 4}), reversed(box({1, 1, 1}, {3, 3, 3})));
  EXPECT_FALSE(state_of(solids({hollow, box({1.5, 1.5, 1.5}, {2.5, 2.5, 2.5})})));
  const auto in_wall = state_of(solids({hollow, box({.25, .25, .25}, {.75, .75, .75})}));
  ASSERT_TRUE(in_wall);
  EXPECT_EQ(in_wall->state, PairState::kSecondInside);
  EXPECT_NEAR(in_wall->depth, std::sqrt(3) / 4, 1e-16);  // a corner of the cavity is nearer than its faces
  EXPECT_EQ(state_of(solids({hollow, box({1, 1, 1}, {3, 3, 3})}))->state, PairState::kTouching);  // fits
}

TEST_F(SolidsTable, Row14Refused) {
  const auto refused = [](const Shape& shape) {
    return refused_field([&] { run_case(solids({shape, unit_cube()}), looking()); });
  };
  Shape open = unit_cube();
  open.triangles.pop_back();
  EXPECT_EQ(refused(open), "meshes[0].solid");
  EXPECT_EQ(refused(reversed(unit_cube())), "meshes[0].solid");
  EXPECT_EQ(refused(box({0, 0, 0}, {1, 1, 0})), "meshes[0].solid");  // volume 0
  EXPECT_EQ(refused(box({0, 0, 0}, {1, 1, 0x1p-1070})), "");         // the least that there is
}

TEST_F(SolidsTable, Row15VerticesUnderCorners) {
  const Positions below{{0, 0, -1}, {.5, 0, -1}, {.5, .5, -1}, {1, 1, -1}},
      on{{0, 0, 0}, {.5, 0, 0}, {.5, .5, 0}, {1, .25, .5}}, within{{.5, .5, .5}, {.25, .25, .25}};
  for (const auto& [positions, inside] : {std::pair{below, 0u}, {on, 0u}, {within, 2u}}) {
    Case c = solids({unit_cube()});
    MeshSpec points;
    points.vertex_count = static_cast<uint32_t>(positions.size()) + 1;  // the last one is no element's
    for (uint32_t v = 0; v < positions.size(); ++v) points.points.push_back(v);
    c.meshes.push_back(points);
    Positions all = positions;
    all.push_back({.5, .5, .75});
    c.start.push_back(all), c.end.push_back(all);
    for (const Accuracy accuracy : kLevels) {
      const FrameResult r = run_case(c, looking(accuracy));
      EXPECT_EQ(r.vertex_solid.size(), inside) << level_name(accuracy);
      EXPECT_EQ(r.pair_states.size(), positions[0][2] < 0 ? 0u : 1u);
      if (positions == on) {
        EXPECT_EQ(r.pair_states[0].state, PairState::kTouching);
      }
      if (inside > 0) {
        EXPECT_EQ(r.pair_states[0].state, PairState::kSecondInside);
      }
    }
  }
}

TEST_F(SolidsTable, Row16WindingNumberTwo) {
  const Shape both = together(box({0, 0, 0}, {2, 2, 2}), box({1, 1, 1}, {3, 3, 3}));
  const auto state = state_of(solids({both, box({1.25, 1.25, 1.25}, {1.75, 1.75, 1.75})}));
  ASSERT_TRUE(state);
  EXPECT_EQ(state->state, PairState::kSecondInside);
  EXPECT_EQ(state->depth, 0.25);
}

TEST_F(SolidsTable, Row19bACavityReachesIn) {
  const Shape hollow = together(box({0, 0, 0}, {10, 10, 10}), reversed(box({4, 4, 4}, {6, 6, 6})));
  const auto state = state_of(solids({hollow, box({3, 3, 3}, {7, 7, 7})}));
  ASSERT_TRUE(state);
  EXPECT_EQ(state->state, PairState::kOverlapping);
  EXPECT_EQ(state->first_inside, 8u);
  EXPECT_EQ(state->second_inside, 8u);
}

TEST_F(SolidsTable, Row25AnyOrderOfIds) {
  for (const Row& row : pairs_of_solids())
    for (uint32_t seed = 1; seed <= 6; ++seed) {
      SCOPED_TRACE(row.name + " seed " + std::to_string(seed));
      const auto [c, origin] = renumbered(row.input, seed);
      expect_row(state_of(solids(c)), expected_of(row.name),
                 origin[0] != 0 && origin[0] >= row.input.meshes[0].vertex_count, 1, 1e-15);
    }
}

TEST_F(SolidsTable, Row26FarAwayAndTiny) {
  for (const Row& row : pairs_of_solids()) {
    if (!std::set<std::string>{"1", "5", "6", "8", "9", "10", "11a", "11b"}.count(row.name)) continue;
    SCOPED_TRACE(row.name);
    expect_row(state_of(solids(moved(row.input, 1, 0x1p40))), expected_of(row.name), false, 1, 1e-15);
    expect_row(state_of(solids(moved(row.input, 0x1p-300, 0))), expected_of(row.name), false, 0x1p-300, 1e-15);
  }
}

TEST_F(SolidsTable, OneSolidAndASheet) {
  const Shape sheet{{{-1, -1, 0}, {2, -1, 0}, {2, 2, 0}, {-1, 2, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  const auto state = [&](double z, double size) {
    Case c = apart({unit_cube(), sheet});
    c.meshes[0].solid = true;
    for (auto* positions : {&c.start[1], &c.end[1]})
      for (Vec3d& p : *positions) p = {p[0] * size, p[1] * size, z};
    return state_of(c);
  };
  EXPECT_EQ(state(0.5, 1)->state, PairState::kOverlapping);
  EXPECT_EQ(state(0, 1)->state, PairState::kTouching);
  EXPECT_FALSE(state(-0.5, 1));
  EXPECT_EQ(state(0.5, 0.25)->state, PairState::kOverlapping);
}

TEST_F(SolidsTable, WhatNobodyAsksForIsNotThere) {
  SceneSpec spec = looking();
  spec.kinds = {.vertex_triangle = true, .edge_edge = true};
  spec.pair_states = false;
  const Case c = solids(pairs_of_solids()[3].input);
  const FrameResult r = run_case(c, spec);
  EXPECT_EQ(r.vertex_solid.size() + r.pair_states.size() + r.edge_triangle.size(), 0u);
  for (const StageTime& stage : r.stages)
    EXPECT_TRUE(stage.stage != "inside" && stage.stage != "solids") << stage.stage;
  spec.pair_states = true;
  const FrameResult asked = run_case(c, spec);
  EXPECT_EQ(asked.pair_states.size(), 1u);
  EXPECT_EQ(asked.vertex_solid.size() + asked.edge_triangle.size(), 0u);
  EXPECT_EQ(asked.counts.contacts.edge_triangle + asked.counts.contacts.vertex_solid, 0u);
}

TEST_F(SolidsTable, AnyHit) {
  SceneSpec spec = looking();
  spec.report = Report::kAnyHit;
  const std::vector<Row> rows = pairs_of_solids();
  EXPECT_TRUE(run_case(solids(rows[6].input), spec).any_contact);
  EXPECT_FALSE(run_case(solids(rows[2].input), spec).any_contact);
  EXPECT_FALSE(run_case(solids(rows[4].input), spec).any_contact);  // crossings are not asked for
  EXPECT_EQ(run_case(solids(rows[6].input), spec).vertex_solid.size(), 0u);
}

TEST_F(SolidsTable, SignedDistances) {
  SceneSpec spec = looking();
  spec.kinds = {.vertex_triangle = true, .edge_edge = true};
  spec.fields = spec.fields.with(ContactField::kSignedDistance);
  spec.thickness = 1;
  const FrameResult r = run_case(solids({box({0, 0, 0}, {10, 10, 10}), box({.5, 4, 4}, {1.5, 5, 5})}), spec);
  ASSERT_GT(r.vertex_triangle.size(), 0u);
  for (const ContactSet* set : {&r.vertex_triangle, &r.edge_edge})
    for (size_t i = 0; i < set->size(); ++i) EXPECT_EQ(set->signed_distance[i], -set->distance[i]);
  for (size_t i = 0; i < r.vertex_triangle.size(); ++i)  // the way out of the larger box
    if (r.vertex_triangle.distance[i] == 0.5) {
      EXPECT_NEAR(r.vertex_triangle.normals[i][0], -1, 1e-6);
    }
  const FrameResult outside = run_case(solids({unit_cube(), box({1.5, .25, .25}, {2, .75, .75})}), spec);
  ASSERT_GT(outside.vertex_triangle.size(), 0u);
  for (size_t i = 0; i < outside.vertex_triangle.size(); ++i)
    EXPECT_EQ(outside.vertex_triangle.signed_distance[i], outside.vertex_triangle.distance[i]);
}

// All its corners are on the cube, and its faces are inside: nothing at its corners tells.
TEST_F(SolidsTable, SignedDistancesOfWhatTouches) {
  SceneSpec spec = looking();
  spec.kinds = {.vertex_triangle = true, .edge_edge = true};
  spec.fields = spec.fields.with(ContactField::kSignedDistance);
  spec.thickness = 1;
  const FrameResult r = run_case(solids({unit_cube(), inscribed(false)}), spec);
  uint32_t touching = 0, other = 0;
  for (const ContactSet* set : {&r.vertex_triangle, &r.edge_edge})
    for (size_t i = 0; i < set->size(); ++i) {
      const bool touches = set->distance[i] == 0;
      ++(touches ? touching : other);
      EXPECT_EQ(std::isnan(set->signed_distance[i]), !touches) << set->distance[i];
    }
  EXPECT_GT(touching, 0u);
  EXPECT_GT(other, 0u);
}

}  // namespace
}  // namespace collided::test
