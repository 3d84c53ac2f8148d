// Triangles that intersect, at every level, against the exact judge.

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/gpu/narrow/crossing_judge.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

constexpr Accuracy kAllLevels[] = {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified,
                                   Accuracy::kExact};

SceneSpec triangles_alone(Accuracy accuracy, Scalar scalar = Scalar::kF64, double thickness = 0) {
  SceneSpec spec = settings(Mode::kDcd, accuracy, scalar, thickness);
  spec.kinds.vertex_triangle = spec.kinds.edge_edge = false;
  spec.kinds.triangle_triangle = true;
  return spec;
}

// Pairs in order, nothing missed, nothing wrongly certain; no arrays but flags.
void expect_promises(const ContactSet& found, const std::vector<PairKey>& truth) {
  const std::vector<PairKey> keys = keys_of(found);
  EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end(), std::less_equal<>())) << "order, or a pair twice";
  EXPECT_TRUE(std::includes(keys.begin(), keys.end(), truth.begin(), truth.end())) << "missed";
  ASSERT_EQ(found.flags.size(), found.size());
  for (size_t i = 0; i < keys.size(); ++i) {
    EXPECT_LT(found.elements[i][0], found.elements[i][1]);
    const bool is_true = std::binary_search(truth.begin(), truth.end(), keys[i]);
    EXPECT_TRUE(found.flags[i] == kFlagNear || (found.flags[i] == kFlagCertified && is_true)) << int{found.flags[i]};
  }
  EXPECT_TRUE(found.toi.empty() && found.distance.empty() && found.weights.empty());
}

using Corners = std::array<uint32_t, 3>;

/// Triangles between few points of a lattice: pairs have none, one, two or three corners in common.
Case woven(uint32_t seed, uint32_t vertices, uint32_t count, double side) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> at(-side, side);
  std::uniform_int_distribution<uint32_t> vertex(0, vertices - 1);
  Positions positions(vertices);
  for (Vec3d& p : positions) p = {std::round(at(random)), std::round(at(random)), std::round(at(random))};
  std::vector<Corners> triangles;
  while (triangles.size() < count) {
    const Corners t{vertex(random), vertex(random), vertex(random)};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
  }
  Case c;
  add_mesh(c, triangles, positions);
  return c;
}

size_t common_corners(const Corners& a, const Corners& b) {
  return static_cast<size_t>(std::ranges::count_if(a, [&](uint32_t v) { return std::ranges::find(b, v) != b.end(); }));
}

/// Of a mesh, those of the pairs that have exactly one corner in common.
size_t count_neighbours(const Case& c, const std::vector<PairKey>& pairs) {
  const std::vector<Corners> triangles = features_of(c).triangles;
  return static_cast<size_t>(std::ranges::count_if(pairs, [&](PairKey key) {
    return common_corners(triangles[key >> 32], triangles[static_cast<uint32_t>(key)]) == 1;
  }));
}

std::vector<PairKey> all_pairs(const Case& c) {
  const auto count = static_cast<uint32_t>(features_of(c).triangles.size());
  std::vector<PairKey> pairs;
  for (uint32_t a = 0; a < count; ++a)
    for (uint32_t b = a + 1; b < count; ++b) pairs.push_back(key_of(a, b));
  return pairs;
}

/// Returns the pairs that intersect.
std::vector<PairKey> expect_judged(const Case& c, Scalar scalar, size_t least) {
  const std::vector<PairKey> truth = CaseJudge(c, Mode::kDcd, 0).triangles();
  EXPECT_GE(truth.size(), least) << "the case tells nothing";
  for (Accuracy accuracy : kAllLevels) {
    SCOPED_TRACE(level_name(accuracy));
    const FrameResult r = run_case(c, triangles_alone(accuracy, scalar));
    expect_promises(r.triangle_triangle, truth);
    EXPECT_EQ(r.vertex_triangle.size() + r.edge_edge.size(), 0u);
    EXPECT_EQ(r.counts.contacts.triangle_triangle, r.triangle_triangle.size());
    EXPECT_EQ(r.any_contact, r.triangle_triangle.size() > 0);
    EXPECT_EQ(r.earliest_toi, 1);
    if (accuracy != Accuracy::kExact) continue;
    EXPECT_EQ(keys_of(r.triangle_triangle), truth);
    for (uint8_t flags : r.triangle_triangle.flags) EXPECT_EQ(flags, kFlagCertified);
  }
  return truth;
}

class TrianglePairs : public OnBackend<::testing::TestWithParam<Scalar>> {};

TEST_P(TrianglePairs, OfRandomSoups) {
  expect_judged(rounded(soup(110, 250, 1, 0.3, 0.1), GetParam()), GetParam(), 100);
  expect_judged(rounded(loose_soup(115, 200, 1, 0.3, 0.1), GetParam()), GetParam(), 50);
  expect_judged(rounded(soup(111, 250, 1, 0.3, 0.1, {1e3, 2e3, -3e3}), GetParam()), GetParam(), 100);
}

// Coplanar, touching in a corner or along an edge, the same triangle twice, segments and points.
TEST_P(TrianglePairs, OfLattices) {
  expect_judged(lattice(112, 120, 6), GetParam(), 100);
  Case flat = lattice(113, 120, 12);
  for (Vec3d& p : flat.end[0]) p[2] = p[0] - p[1];
  expect_judged(flat, GetParam(), 100);
}

// Neighbours that cross, touch beyond their corner, lie on each other, are segments and points.
TEST_P(TrianglePairs, OfNeighboursOnLattices) {
  size_t neighbours = 0, meeting = 0;
  for (const double side : {1, 2, 3, 6, 40}) {
    const Case c = woven(118 + static_cast<uint32_t>(side), 30, 150, side);
    neighbours += count_neighbours(c, all_pairs(c));
    meeting += count_neighbours(c, expect_judged(c, GetParam(), 100));
  }
  EXPECT_GE(neighbours, 10000u);
  EXPECT_GE(meeting, 1000u);
  EXPECT_GE(neighbours - meeting, 1000u);
}

// In general position bounds in double tell everything.
TEST_P(TrianglePairs, OfASheetWithItself) {
  for (const double by : {0.1, 0.9, 1.5}) {
    const Case c = rounded(crumpled(119, 14, by), GetParam());
    expect_judged(c, GetParam(), by == 1.5 ? 350 : by == 0.9 ? 80 : 0);
    const FrameResult certified = run_case(c, triangles_alone(Accuracy::kCertified, GetParam()));
    EXPECT_TRUE(same_bytes(certified.triangle_triangle,
                           run_case(c, triangles_alone(Accuracy::kExact, GetParam())).triangle_triangle));
    if (by > 0.5) {
      EXPECT_GT(count_neighbours(c, keys_of(certified.triangle_triangle)), 20u);
    }
  }
}

// Most of what a level cannot be sure of is no contact: a hair apart in a tilted plane.
TEST_P(TrianglePairs, OfNearMisses) {
  Case c = lattice(114, 120, 12);
  for (size_t v = 0; v < c.end[0].size(); ++v) {
    Vec3d& p = c.end[0][v];
    p[2] = p[0] - p[1] + std::ldexp(static_cast<double>(v / 3), GetParam() == Scalar::kF32 ? -20 : -45);
  }
  c = rounded(c, GetParam());
  const size_t guarded = run_case(c, triangles_alone(Accuracy::kGuarded, GetParam())).triangle_triangle.size();
  const size_t exact = run_case(c, triangles_alone(Accuracy::kExact, GetParam())).triangle_triangle.size();
  EXPECT_GT(guarded, exact) << "no near misses";
  expect_judged(c, GetParam(), 0);
}

INSTANTIATE_TEST_SUITE_P(Scalars, TrianglePairs, ::testing::Values(Scalar::kF32, Scalar::kF64),
                         [](const auto& info) { return info.param == Scalar::kF32 ? "F32" : "F64"; });

using TrianglePairRules = OnBackend<>;

// A common side is no contact, not even where both triangles lie on each other; nor is a common corner by itself.
TEST_F(TrianglePairRules, WhatNeighboursShareIsNoContact) {
  Case tent, flat = crumpled(1, 12, 0), folded, pair;
  add_mesh(tent, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  add_mesh(folded, {{0, 1, 2}, {1, 0, 3}, {2, 1, 0}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.5, 0}});
  add_mesh(pair, {{0, 1, 2}, {3, 0, 4}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}});
  for (const Case& c : {tent, flat, folded, pair})
    for (const Accuracy accuracy : kAllLevels) {
      const FrameResult r = run_case(c, triangles_alone(accuracy));
      EXPECT_EQ(r.triangle_triangle.size(), 0u) << level_name(accuracy);
      EXPECT_FALSE(r.any_contact);
      EXPECT_EQ(r.counts.exact_decisions, 0u) << "each is a look of the host's";
    }
}

// The far side of one goes through the other, or just reaches it: with its inside, along it, with its end.
TEST_F(TrianglePairRules, NeighboursThatMeetBeyondTheirCornerAreAContact) {
  const auto fan = [](const Vec3d& p, const Vec3d& q) {
    Case c;
    add_mesh(c, {{1, 2, 0}, {4, 0, 3}}, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, p, q});
    return c;
  };
  const auto count = [](const Case& c, Accuracy accuracy = Accuracy::kExact) {
    return run_case(c, triangles_alone(accuracy)).triangle_triangle.size();
  };
  for (const auto& [p, q] : {std::pair<Vec3d, Vec3d>{{2, 1, -1}, {2, 1.5, 2}},
                             {{1, 1, 0}, {2, 2, 5}},
                             {{1, 1, 0}, {1, 2, 0}},
                             {{9, 9, 0}, {9, 9, 9}},
                             {{5, -1, 0}, {5, 9, 0}}})
    EXPECT_EQ(count(fan(p, q)), 1u) << p[0] << " " << p[1];
  for (const auto& [p, q] :
       {std::pair<Vec3d, Vec3d>{{-1, 1, 0}, {1, -1, 4}}, {{-4, 0, 0}, {1, 3, 9}}, {{-1, 0, 0}, {9, -1, 0}}})
    EXPECT_EQ(count(fan(p, q)), 0u) << p[0] << " " << p[1];
  Case c = fan({2, 1, -1}, {2, 1.5, 2});
  for (const Accuracy accuracy : kAllLevels) {
    const ContactSet found = run_case(c, triangles_alone(accuracy)).triangle_triangle;
    ASSERT_EQ(found.size(), 1u) << level_name(accuracy);
    EXPECT_EQ(found.flags[0], kFlagCertified);
  }
  c.meshes[0].excluded_rings = 1;
  EXPECT_EQ(count(c), 0u);
  c.meshes[0].excluded_rings = 0, c.meshes[0].self_contacts = false;
  EXPECT_EQ(count(c), 0u);
}

// An edge through a triangle makes a pair with each triangle that has the edge. In general position there are no
// others.
TEST_F(TrianglePairRules, PairsAreThoseOfTheCrossings) {
  const Case c = crumpled(120, 24, 1.2);
  SceneSpec spec = triangles_alone(Accuracy::kCertified);
  spec.kinds.edge_triangle = true;
  const auto detector = Detector::create(spec_for(c, spec));
  const FrameResult r = detector->detect(Frame(c, Mode::kDcd, Scalar::kF64).input());
  std::vector<PairKey> pairs;
  for (const auto& [pair, ends] : contour_ends(r.edge_triangle.elements, detector->topology())) pairs.push_back(pair);
  EXPECT_GT(count_neighbours(c, pairs), 100u);
  EXPECT_EQ(keys_of(r.triangle_triangle), pairs);
}

TEST_F(TrianglePairRules, AreTheSameForEachEngineAndAnyNumberOfThreads) {
  const Case c = crumpled(121, 24, 1.2);
  const FrameResult expected = run_case(c, triangles_alone(Accuracy::kCertified));
  EXPECT_GT(count_neighbours(c, keys_of(expected.triangle_triangle)), 100u);
  for (const Engine engine :
       {Engine::kOctree, Engine::kTopDown, Engine::kUniformGrid, Engine::kLbvh, Engine::kVss, Engine::kAllPairs})
    for (const int threads : {1, 3}) {
      SceneSpec spec = triangles_alone(Accuracy::kCertified);
      spec.engine = engine, spec.threads = threads;
      EXPECT_TRUE(same_bytes(run_case(c, spec).triangle_triangle, expected.triangle_triangle))
          << static_cast<int>(engine) << ", " << threads << " threads";
    }
}

TEST_F(TrianglePairRules, ThicknessPlaysNoPart) {
  const Case c = soup(115, 200, 1, 0.2, 0.1);
  for (Accuracy accuracy : kAllLevels) {
    const FrameResult thin = run_case(c, triangles_alone(accuracy));
    const FrameResult thick = run_case(c, triangles_alone(accuracy, Scalar::kF64, 0.1));
    EXPECT_GT(thin.triangle_triangle.size(), 20u);
    EXPECT_TRUE(same_bytes(thin.triangle_triangle, thick.triangle_triangle)) << level_name(accuracy);
  }
}

// With the other kinds the triangle pairs are the same, and the other kinds are what they are without.
TEST_F(TrianglePairRules, KindsDoNotDisturbEachOther) {
  const Case c = soup(116, 200, 1, 0.2, 0.1);
  for (Accuracy accuracy : kAllLevels) {
    SceneSpec spec = settings(Mode::kDcd, accuracy, Scalar::kF64, 0.01);
    const FrameResult features = run_case(c, spec);
    spec.kinds.triangle_triangle = true;
    const FrameResult all = run_case(c, spec);
    EXPECT_TRUE(same_contacts(features, all));
    const FrameResult alone = run_case(c, triangles_alone(accuracy, Scalar::kF64, 0.01));
    EXPECT_TRUE(same_bytes(alone.triangle_triangle, all.triangle_triangle));
  }
}

std::vector<uint32_t> mesh_of_triangle(const Case& c) {
  std::vector<uint32_t> mesh;
  for (uint32_t m = 0; m < c.meshes.size(); ++m) mesh.insert(mesh.end(), count_elements(c.meshes[m]), m);
  return mesh;
}

bool may_touch(const Case& c, uint32_t i, uint32_t j) {
  const MeshSpec &a = c.meshes[i], &b = c.meshes[j];
  if (a.motion == MeshMotion::kStatic && b.motion == MeshMotion::kStatic) return false;
  return i == j ? a.self_contacts : (a.groups & b.collide_mask) && (b.groups & a.collide_mask);
}

// Of all intersecting pairs those that the meshes' rules let through.
TEST_F(TrianglePairRules, MeshesThatMayNotTouchHaveNone) {
  for (const char* name : {"StaticObstacles", "GroupMasks", "NoSelfContacts"}) {
    SCOPED_TRACE(name);
    const std::vector<Case> cases = adversarial_cases();
    const Case& c = *std::find_if(cases.begin(), cases.end(), [&](const Case& x) { return x.name == name; });
    const std::vector<uint32_t> mesh = mesh_of_triangle(c);
    const std::vector<PairKey> all = CaseJudge(c, Mode::kDcd, 0).triangles();
    std::vector<PairKey> expected;
    std::copy_if(all.begin(), all.end(), std::back_inserter(expected),
                 [&](PairKey key) { return may_touch(c, mesh[key >> 32], mesh[static_cast<uint32_t>(key)]); });
    EXPECT_GT(expected.size(), 10u);
    EXPECT_LT(expected.size(), all.size()) << "the rules let all through";
    for (Accuracy accuracy : {Accuracy::kCertified, Accuracy::kExact})
      EXPECT_EQ(keys_of(run_case(c, triangles_alone(accuracy)).triangle_triangle), expected);
  }
}

// A triangle that another one pierces, with no feature near another: a contact of triangles alone.
Case pierced() {
  Case c;
  add_mesh(c, {{0, 1, 2}}, {{-4, -4, 0}, {4, -4, 0}, {0, 4, 0}});
  add_mesh(c, {{0, 1, 2}}, {{0, 0, 2}, {1, 0, -2}, {-1, 0, -2}});
  return c;
}
// Boxes that overlap, nothing else.
Case beside() {
  Case c;
  add_mesh(c, {{0, 1, 2}}, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}});
  add_mesh(c, {{0, 1, 2}}, {{3, 3, -1}, {4, 3, 1}, {3, 4, 1}});
  return c;
}

// Candidates of features are no contacts, but triangle pairs are contacts at every level.
TEST_F(TrianglePairRules, CountAsContactsAtEveryLevel) {
  for (Accuracy accuracy : kAllLevels) {
    SCOPED_TRACE(level_name(accuracy));
    SceneSpec spec = settings(Mode::kDcd, accuracy, Scalar::kF64, 0x1p-10);
    EXPECT_FALSE(run_case(pierced(), spec).any_contact);
    spec.kinds.triangle_triangle = true;
    EXPECT_TRUE(run_case(pierced(), spec).any_contact);
    EXPECT_FALSE(run_case(beside(), spec).any_contact);
  }
  for (const Case& c : {pierced(), beside()}) {
    const FrameResult candidates = run_case(c, settings(Mode::kDcd, Accuracy::kCandidates));
    EXPECT_GT(candidates.vertex_triangle.size() + candidates.edge_edge.size(), 0u) << "the case has no candidates";
  }
}

/// A triangle's box over the step, rounded outward to float.
struct FloatBox {
  std::array<float, 3> lo, hi;

  bool overlaps(const FloatBox& other) const {
    for (size_t k = 0; k < 3; ++k)
      if (lo[k] > other.hi[k] || other.lo[k] > hi[k]) return false;
    return true;
  }
};

float float_toward(double x, float to) {
  const float nearest = static_cast<float>(x);
  const bool is_beyond = to < 0 ? static_cast<double>(nearest) <= x : static_cast<double>(nearest) >= x;
  return is_beyond ? nearest : std::nextafter(nearest, to);
}

Positions joined(const std::vector<Positions>& meshes) {
  Positions all;
  for (const Positions& mesh : meshes) all.insert(all.end(), mesh.begin(), mesh.end());
  return all;
}

std::vector<FloatBox> swept_boxes(const Case& c, const std::vector<std::array<uint32_t, 3>>& triangles) {
  const Positions start = joined(c.start), end = joined(c.end);
  std::vector<FloatBox> boxes;
  for (const auto& triangle : triangles) {
    FloatBox box;
    for (size_t k = 0; k < 3; ++k) {
      double lo = HUGE_VAL, hi = -HUGE_VAL;
      for (const uint32_t v : triangle) {
        lo = std::min({lo, start[v][k], end[v][k]});
        hi = std::max({hi, start[v][k], end[v][k]});
      }
      box.lo[k] = float_toward(lo, -HUGE_VALF), box.hi[k] = float_toward(hi, HUGE_VALF);
    }
    boxes.push_back(box);
  }
  return boxes;
}

bool share_a_vertex(const std::array<uint32_t, 3>& a, const std::array<uint32_t, 3>& b) {
  return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}

/// All pairs that may touch, have no vertex in common, and whose boxes overlap; ascending.
std::vector<PairKey> overlapping_pairs(const Case& c) {
  const Features features = features_of(c);
  const auto& triangles = features.triangles;
  const std::vector<FloatBox> boxes = swept_boxes(c, triangles);
  const std::vector<uint32_t> mesh = mesh_of_triangle(c);
  const auto is_triangle = [&](uint32_t t) { return features.kinds[t] == ElementKind::kTriangle; };
  std::vector<PairKey> pairs;
  for (uint32_t a = 0; a < triangles.size(); ++a)
    for (uint32_t b = a + 1; b < triangles.size(); ++b)
      if (is_triangle(a) && is_triangle(b) && boxes[a].overlaps(boxes[b]) &&
          !share_a_vertex(triangles[a], triangles[b]) && may_touch(c, mesh[a], mesh[b]))
        pairs.push_back(key_of(a, b));
  return pairs;
}

class TriangleCandidates : public OnBackend<::testing::TestWithParam<Scalar>> {
 protected:
  SceneSpec spec() const {
    SceneSpec spec = settings(Mode::kCcd, Accuracy::kCandidates, GetParam());
    spec.kinds.triangle_triangle = true;
    return spec;
  }

  void expect_overlapping(const Case& exact) const {
    SCOPED_TRACE(exact.name);
    const Case c = rounded(exact, GetParam());
    SceneSpec alone = spec();
    alone.kinds.vertex_triangle = alone.kinds.edge_edge = false;
    const std::vector<PairKey> expected = overlapping_pairs(c);
    EXPECT_GT(expected.size(), 0u);
    const FrameResult with_features = run_case(c, spec()), without = run_case(c, alone);
    for (const FrameResult* result : {&with_features, &without}) {
      const ContactSet& found = result->triangle_triangle;
      EXPECT_EQ(keys_of(found), expected);
      EXPECT_TRUE(found.flags.empty() && found.toi.empty() && found.distance.empty() && found.weights.empty());
      EXPECT_FALSE(result->any_contact) << "boxes that overlap are no contact";
      EXPECT_EQ(result->counts.contacts.triangle_triangle, 0u);
    }
    EXPECT_TRUE(same_contacts(run_case(c, settings(Mode::kCcd, Accuracy::kCandidates, GetParam())), with_features));
  }
};

TEST_P(TriangleCandidates, AreThePairsWhoseSweptBoxesOverlap) {
  const auto scene = scenes::make_scene("reef_knot", 0.3);
  expect_overlapping(case_of(*scene, 0.5, 0.55));
  expect_overlapping(soup(260, 1500, 1, 0.1, 0.05));
  expect_overlapping(soup(261, 500, 1, 0.1, 0.05, {1e6, -2e6, 3e6}));
  expect_overlapping(lattice(262, 300, 10));
  expect_overlapping(loose_soup(263, 400, 1, 0.2, 0.05));
}

TEST_P(TriangleCandidates, FollowTheRulesOfTheMeshes) {
  for (const Case& c : adversarial_cases())
    if (c.name == "StaticObstacles" || c.name == "GroupMasks" || c.name == "NoSelfContacts") expect_overlapping(c);
}

// What is refused names its field and says where it is allowed.
template <class Action>
void expect_refused(Action&& action) {
  try {
    action();
    ADD_FAILURE() << "not refused";
  } catch (const InvalidInput& e) {
    EXPECT_EQ(e.field(), "triangle_triangle");
    EXPECT_NE(std::string(e.what()).find("CANDIDATES"), std::string::npos) << e.what();
  }
}

TEST_P(TriangleCandidates, AreRefusedAtOtherLevels) {
  const Case c = rounded(soup(263, 100, 1, 0.3, 0.1), GetParam());
  const Frame frame(c, Mode::kCcd, GetParam());
  auto scene = Detector::create(spec_for(c, spec()));
  const FrameResult first = scene->detect(frame.input());
  for (Accuracy accuracy : kAllLevels) {
    if (accuracy == Accuracy::kCandidates) continue;
    SCOPED_TRACE(level_name(accuracy));
    SceneSpec refused = spec();
    refused.accuracy = accuracy;
    expect_refused([&] { Detector::create(spec_for(c, refused)); });
    FrameInput input = frame.input();
    input.accuracy = accuracy;
    expect_refused([&] { scene->detect(input); });
  }
  EXPECT_TRUE(same_bytes(first.triangle_triangle, scene->detect(frame.input()).triangle_triangle));
}

INSTANTIATE_TEST_SUITE_P(Scalars, TriangleCandidates, ::testing::Values(Scalar::kF32, Scalar::kF64),
                         [](const auto& info) { return info.param == Scalar::kF32 ? "F32" : "F64"; });

}  // namespace
}  // namespace collided::test
