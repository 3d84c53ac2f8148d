// Normals: unit, and such that no other direction keeps the features farther apart. What that is at the time of the
// contact is decided in rational arithmetic.

#include <cmath>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/judged_case.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/every_field.hpp"
#include "tests/support/frames/real_frames.hpp"
#include "tests/support/judge/exact_normal.hpp"

namespace collided::test {
namespace {

constexpr double kUnitTolerance = 1e-6;  // of the squared length: normals are rounded to float

double extent_of(const Query& query) {
  double extent = 0;
  for (size_t i = 0; i < 4; ++i)
    for (size_t k = 0; k < 3; ++k)
      for (size_t time : {0, 4}) extent = std::max(extent, std::abs(query.p[i + time][k] - query.p[time][k]));
  return extent;
}

std::array<Vec3d, 4> points_at(const Query& query, size_t first) {
  return {query.p[first], query.p[first + 1], query.p[first + 2], query.p[first + 3]};
}

struct NormalsParam {
  Scalar scalar;
  Accuracy accuracy;
};

void PrintTo(const NormalsParam& param, std::ostream* out) {
  *out << level_name(param.accuracy) << (param.scalar == Scalar::kF32 ? "_F32" : "_F64");
}

class Normals : public OnBackend<::testing::TestWithParam<NormalsParam>> {
 protected:
  SceneSpec spec(Mode mode, double thickness) const {
    SceneSpec spec = settings(mode, GetParam().accuracy, GetParam().scalar, thickness);
    spec.fields = kEveryField;
    return spec;
  }
  // Of the extent of the features: of float's rounding where that is all there is.
  double tolerance() const { return GetParam().accuracy <= Accuracy::kGuarded ? 1e-4 : 1e-6; }

  void expect_unit(const ExactNormal& normal) const {
    EXPECT_LT(std::abs(normal.squared_length.get_d() - 1), kUnitTolerance);
  }
  // The features' distance in `p` is no more than the normal tells.
  void expect_gap_is_distance(const Query& query, size_t time, const ExactNormal& normal) const {
    const double bound = normal.gap.get_d() + tolerance() * extent_of(query);
    ASSERT_GE(bound, 0) << "the normal does not part the features";
    EXPECT_TRUE(judge_proximity(query.kind, points_at(query, time), bound)) << "gap " << normal.gap.get_d();
  }

  void expect_discrete(const Case& exact, double thickness, size_t least) const {
    const Case c = rounded(exact, GetParam().scalar);
    const FrameResult r = run_case(c, spec(Mode::kDcd, thickness));
    const CaseQueries queries(c);
    size_t contacts = 0;
    for_each_contact(r, [&](QueryKind kind, PairKey pair, const ContactSet& set, size_t i) {
      Query query = queries.of_pair(kind, pair);
      std::copy_n(query.p.begin() + 4, 4, query.p.begin());
      const ExactNormal normal = judge_normal(query, 0, set.normals[i]);
      expect_unit(normal);
      expect_gap_is_distance(query, 0, normal);
      ++contacts;
    });
    EXPECT_GE(contacts, least);
  }

  void expect_continuous(const Case& exact, double thickness, size_t least) const {
    const Case c = rounded(exact, GetParam().scalar);
    const FrameResult r = run_case(c, spec(Mode::kCcd, thickness));
    const CaseQueries queries(c);
    // With a thickness FAST tells no first time: the features may be nearer by then, and parting.
    const bool is_first = thickness == 0 || GetParam().accuracy != Accuracy::kFast;
    size_t contacts = 0;
    for_each_contact(r, [&](QueryKind kind, PairKey pair, const ContactSet& set, size_t i) {
      const Query query = queries.of_pair(kind, pair);
      const ExactNormal normal = judge_normal(query, mpq_class(set.toi[i]), set.normals[i]);
      expect_unit(normal);
      if (set.toi[i] == 0) {
        expect_gap_is_distance(query, 0, normal);
      } else {
        EXPECT_GE(normal.gap.get_d(), (is_first ? thickness : 0) - tolerance() * extent_of(query));
        const double parting = is_first ? approach(query, set, i) : 0;
        EXPECT_LE(parting, tolerance() * extent_of(query)) << "toi " << set.toi[i];
      }
      ++contacts;
    });
    EXPECT_GE(contacts, least);
  }

 private:
  template <class Check>
  static void for_each_contact(const FrameResult& result, const Check& check) {
    for (const auto& [kind, set] : {std::pair(QueryKind::kVertexTriangle, &result.vertex_triangle),
                                    std::pair(QueryKind::kEdgeEdge, &result.edge_edge)}) {
      const std::vector<PairKey> keys = keys_of(*set);
      ASSERT_EQ(set->normals.size(), keys.size());
      for (size_t i = 0; i < keys.size() && !::testing::Test::HasFailure(); ++i) {
        SCOPED_TRACE(std::to_string(i) + (kind == QueryKind::kVertexTriangle ? " VT" : " EE"));
        check(kind, keys[i], *set, i);
      }
    }
  }
  // How far the first feature's point moves along the normal against the second's: not away from it, or they would have
  // touched before.
  static double approach(const Query& query, const ContactSet& set, size_t i) {
    const auto [w0, w1] = set.weights[i];
    const bool is_vt = query.kind == QueryKind::kVertexTriangle;
    const std::array<double, 4> weights =
        is_vt ? std::array{1.0, w0 + w1 - 1, -w0, -w1} : std::array{1 - w0, w0, w1 - 1, -w1};
    double sum = 0;
    for (size_t v = 0; v < 4; ++v)
      for (size_t k = 0; k < 3; ++k) sum += weights[v] * set.normals[i][k] * (query.p[v + 4][k] - query.p[v][k]);
    return sum;
  }
};

TEST_P(Normals, PartFeaturesOfASoup) {
  const Case c = soup(11, 1200, 1, 0.1, 0.05);
  expect_discrete(c, 0.02, 1000);
  expect_continuous(c, 0, 40);
  expect_continuous(c, 0.01, 300);
}

// Integers: features that touch, are coplanar and parallel, coincide, or are no more than a point.
TEST_P(Normals, PartDegenerateFeatures) {
  const Case c = lattice(12, 60, 5);
  if (GetParam().accuracy != Accuracy::kFast) expect_discrete(c, 0, 100);
  expect_discrete(c, 1, 100);
  expect_continuous(c, 0, 100);
}

TEST_P(Normals, PartLooseElements) {
  const Case c = loose_soup(14, 300, 1, 0.1, 0.05), integers = on_integers(loose_soup(17, 30, 4, 4, 4));
  expect_discrete(c, 0.02, 300);
  expect_continuous(c, 0.01, 100);
  expect_discrete(integers, 1, 100);
  expect_continuous(integers, 0, 50);
}

TEST_P(Normals, PartClothThatFalls) {
  const Case c = load(kDrapeFrames);
  expect_continuous(c, 0, 20);
  expect_discrete(c, 0.001, 20);
}

INSTANTIATE_TEST_SUITE_P(
    Levels, Normals,
    ::testing::Values(NormalsParam{Scalar::kF32, Accuracy::kFast}, NormalsParam{Scalar::kF64, Accuracy::kFast},
                      NormalsParam{Scalar::kF32, Accuracy::kGuarded}, NormalsParam{Scalar::kF64, Accuracy::kGuarded},
                      NormalsParam{Scalar::kF32, Accuracy::kCertified},
                      NormalsParam{Scalar::kF64, Accuracy::kCertified}, NormalsParam{Scalar::kF32, Accuracy::kExact},
                      NormalsParam{Scalar::kF64, Accuracy::kExact}),
    [](const auto& info) { return ::testing::PrintToString(info.param); });

using NormalOf = OnBackend<>;

// A triangle at z = 0, and one whose lowest corner or edge moves.
Normal normal_of(const Positions& start, const Positions& end, bool edges) {
  Case c;
  add_mesh(c, {{0, 1, 2}}, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, {}, true);
  add_mesh(c, {{0, 1, 2}}, start, end);
  SceneSpec spec = settings(Mode::kCcd, Accuracy::kCertified);
  spec.fields = kEveryField;
  spec.kinds.vertex_triangle = !edges, spec.kinds.edge_edge = edges;
  const FrameResult r = run_case(c, spec);
  const ContactSet& set = edges ? r.edge_edge : r.vertex_triangle;
  EXPECT_GE(set.normals.size(), 1u);
  return set.normals.empty() ? Normal{} : set.normals[0];
}

void expect_near(const Normal& normal, const std::array<double, 3>& expected) {
  for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(normal[k], expected[k], 1e-6) << "component " << k;
}

TEST_F(NormalOf, WhatTouchesPointsToWhereTheFirstFeatureCameFrom) {
  expect_near(normal_of({{1, 1, 1}, {1, 1, 3}, {2, 1, 3}}, {{1, 1, -1}, {1, 1, 1}, {2, 1, 1}}, false), {0, 0, 1});
  expect_near(normal_of({{1, 1, -1}, {1, 1, -3}, {2, 1, -3}}, {{1, 1, 1}, {1, 1, -1}, {2, 1, -1}}, false), {0, 0, -1});
}

// The static edge from (0, 0, 0) to (4, 0, 0) is the first feature, and comes from above to the one that rises.
TEST_F(NormalOf, EdgesThatCross) {
  expect_near(normal_of({{1, -1, -1}, {1, 1, -1}, {1, 0, -9}}, {{1, -1, 1}, {1, 1, 1}, {1, 0, -7}}, true), {0, 0, 1});
}

// Without a common normal: against the motion, across the edges.
TEST_F(NormalOf, ParallelEdges) {
  expect_near(normal_of({{1, -1, 0}, {2, -1, 0}, {1, -9, 0}}, {{1.5, 1, 0}, {2.5, 1, 0}, {1.5, -7, 0}}, true),
              {0, 1, 0});
}

// All is in the plane z = 0: a corner runs into a side.
TEST_F(NormalOf, AnImpactWithinAPlaneIsInThePlane) {
  for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact}) {
    Case c;
    add_mesh(c, {{0, 1, 2}}, {{0, -1, 0}, {0, 1, 0}, {-2, 0, 0}});
    add_mesh(c, {{0, 1, 2}}, {{1, 0, 0}, {2, .5, 0}, {2, -.5, 0}}, {{-1, 0, 0}, {0, .5, 0}, {0, -.5, 0}});
    SceneSpec spec = settings(Mode::kCcd, accuracy);
    spec.fields = kEveryField;
    const FrameResult r = run_case(c, spec);
    ASSERT_GT(r.vertex_triangle.size() + r.edge_edge.size(), 0u);
    for (const ContactSet* set : {&r.vertex_triangle, &r.edge_edge})
      for (const Normal& normal : set->normals) EXPECT_GT(std::abs(normal[0]), 0.99) << level_name(accuracy);
  }
}

TEST_F(NormalOf, TrianglePairsAndCandidatesHaveNone) {
  const Case c = soup(13, 200, 0.5, 0.2, 0.05);
  SceneSpec spec = settings(Mode::kDcd, Accuracy::kCertified, Scalar::kF64, 0.01);
  spec.fields = kEveryField, spec.kinds.triangle_triangle = true;
  const FrameResult r = run_case(c, spec);
  ASSERT_GT(r.triangle_triangle.size(), 0u);
  EXPECT_TRUE(r.triangle_triangle.normals.empty());
  EXPECT_EQ(r.edge_edge.normals.size(), r.edge_edge.size());
  spec.fields = spec.fields.without(ContactField::kNormals);
  EXPECT_TRUE(run_case(c, spec).edge_edge.normals.empty());
  spec.fields = kEveryField, spec.accuracy = Accuracy::kCandidates;
  EXPECT_TRUE(run_case(c, spec).edge_edge.normals.empty());
}

}  // namespace
}  // namespace collided::test
