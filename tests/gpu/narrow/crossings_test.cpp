// Edges that go through triangles, against rationals: all of them, at every level, with neighbours.

#include "gpu/exact/crossings.hpp"

#include <gmpxx.h>

#include <algorithm>
#include <optional>
#include <random>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
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

using Exact = std::array<mpq_class, 3>;

Exact exact(const Vec3d& p) { return {mpq_class(p[0]), mpq_class(p[1]), mpq_class(p[2])}; }
Exact minus(const Exact& a, const Exact& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
int orientation(const Exact& a, const Exact& b, const Exact& c, const Exact& d) {
  const Exact p = minus(b, a), q = minus(c, a), r = minus(d, a);
  return sgn(p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) +
             p[2] * (q[0] * r[1] - q[1] * r[0]));
}

/// Whether the edge u v goes through the triangle; nothing where a determinant is 0.
std::optional<bool> crosses(const Exact& u, const Exact& v, const std::array<Exact, 3>& t) {
  const int from = orientation(t[0], t[1], t[2], u), to = orientation(t[0], t[1], t[2], v);
  int sides[3];
  for (size_t k = 0; k < 3; ++k) sides[k] = orientation(u, v, t[k], t[(k + 1) % 3]);
  if (from * to > 0) return false;
  const auto [least, greatest] = std::minmax({sides[0], sides[1], sides[2]});
  if (least < 0 && greatest > 0) return false;
  if (from == 0 || to == 0 || least == 0 || greatest == 0) return std::nullopt;
  return true;
}

/// A case as one scene: its features by scene-wide ids.
struct Surface {
  explicit Surface(const Case& c) : topology(Detector::create(spec_for(c, crossings_alone()))->topology()) {
    for (const Positions& mesh : c.end) positions.insert(positions.end(), mesh.begin(), mesh.end());
  }
  bool is_loose(size_t t) const { return topology.triangles[t][1] == topology.triangles[t][2]; }
  bool share_vertex(size_t e, size_t t) const {
    for (const uint32_t v : topology.edges[e])
      if (std::ranges::find(topology.triangles[t], v) != topology.triangles[t].end()) return true;
    return false;
  }

  Topology topology;
  Positions positions;
};

struct Judged {
  std::vector<PairKey> sure, tied;
};

/// Whether the boxes of two sets of vertices are apart; comparisons are exact.
template <class Some, class Others>
bool are_apart(const Positions& p, const Some& some, const Others& others) {
  for (size_t k = 0; k < 3; ++k) {
    const auto at = [&](uint32_t v) { return p[v][k]; };
    const auto [a, b] = std::ranges::minmax(some, {}, at);
    const auto [c, d] = std::ranges::minmax(others, {}, at);
    if (at(b) < at(c) || at(d) < at(a)) return true;
  }
  return false;
}

/// All pairs of an edge and a triangle with no common vertex. Ties are decided by the engine's own exact arithmetic,
/// which tests/gpu/exact judges.
Judged judge(const Surface& surface) {
  Judged judged;
  std::vector<Exact> points;
  for (const Vec3d& p : surface.positions) points.push_back(exact(p));
  for (size_t e = 0; e < surface.topology.edges.size(); ++e)
    for (size_t t = 0; t < surface.topology.triangles.size(); ++t) {
      if (surface.is_loose(t) || surface.share_vertex(e, t)) continue;
      if (are_apart(surface.positions, surface.topology.edges[e], surface.topology.triangles[t])) continue;
      const auto [u, v] = surface.topology.edges[e];
      const auto& ids = surface.topology.triangles[t];
      const auto answer = crosses(points[u], points[v], {points[ids[0]], points[ids[1]], points[ids[2]]});
      const PairKey key = key_of(static_cast<uint32_t>(e), static_cast<uint32_t>(t));
      if (answer) {
        if (*answer) judged.sure.push_back(key);
        continue;
      }
      const auto at = [&](uint32_t id) {
        const Vec3d& p = surface.positions[id];
        return Vec3<double>{p[0], p[1], p[2]};
      };
      const EdgeTriangleVerdict verdict =
          exact_edge_triangle({at(u), at(v), at(ids[0]), at(ids[1]), at(ids[2])}, {u, v, ids[0], ids[1], ids[2]});
      if (verdict.crosses) judged.tied.push_back(key);
    }
  return judged;
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
  const Judged judged = judge(surface);
  EXPECT_GE(judged.sure.size(), least) << "the case tells nothing";
  std::vector<PairKey> all = judged.sure;
  all.insert(all.end(), judged.tied.begin(), judged.tied.end());
  std::sort(all.begin(), all.end());
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

/// A sheet of n x n cells whose vertices are moved at random: it goes through itself, neighbours through each other.
Case crumpled(uint32_t seed, uint32_t n, double by) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> move(-by, by);
  Positions positions;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 0; i <= n; ++i)
    for (uint32_t j = 0; j <= n; ++j) positions.push_back({i + move(random), j + move(random), move(random)});
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = 0; j < n; ++j) {
      const uint32_t a = i * (n + 1) + j, b = a + 1, c = a + n + 1, d = c + 1;
      triangles.push_back({a, c, b}), triangles.push_back({b, c, d});
    }
  Case c;
  add_mesh(c, triangles, positions);
  return c;
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
