// DCD of features without length or area: apart where they are, and only there, by the exact judge.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "gpu/narrow/certified_proximity.hpp"
#include "tests/support/distance.hpp"
#include "tests/support/families/query_families_shapes.hpp"
#include "tests/support/verdicts/query_batch.hpp"

namespace collided::test {
namespace {

constexpr int kQueriesOfFamily = 400;

struct Family {
  std::string name;
  QueryKind kind;
  Points (*make)(Random&);
};

Vec3d anywhere(Random& random) { return times(1.0 / 1024, random.lattice(4096)); }
Vec3d along(const Vec3d& from, const Vec3d& direction, Random& random) {
  return plus(from, times(random.within(-1, 1), direction));
}

const std::vector<Family>& families() {
  static const std::vector<Family> all = {
      {"first edge a point", QueryKind::kEdgeEdge,
       [](Random& r) {
         const Vec3d p = anywhere(r);
         return Points{p, p, anywhere(r), anywhere(r)};
       }},
      {"second edge a point", QueryKind::kEdgeEdge,
       [](Random& r) {
         const Vec3d p = anywhere(r);
         return Points{anywhere(r), anywhere(r), p, p};
       }},
      {"both edges points", QueryKind::kEdgeEdge,
       [](Random& r) {
         const Vec3d p = anywhere(r), q = anywhere(r);
         return Points{p, p, q, q};
       }},
      {"an edge of nearly no length", QueryKind::kEdgeEdge,
       [](Random& r) {
         const Vec3d p = anywhere(r), q = plus(p, r.vector(std::abs(r.signed_power(-60, -8))));
         return r.chance(0.5) ? Points{p, q, anywhere(r), anywhere(r)} : Points{anywhere(r), anywhere(r), p, q};
       }},
      {"parallel edges", QueryKind::kEdgeEdge,
       [](Random& r) {
         const Vec3d p = anywhere(r), q = anywhere(r), d = anywhere(r);
         return Points{p, plus(p, d), q, plus(q, times(r.signed_power(-4, 2), d))};
       }},
      {"edges on a line", QueryKind::kEdgeEdge,
       [](Random& r) {
         const Vec3d p = anywhere(r), d = anywhere(r), q = along(p, times(8, d), r);
         return Points{p, along(p, d, r), q, along(q, d, r)};
       }},
      {"a triangle that is a line", QueryKind::kVertexTriangle,
       [](Random& r) {
         const Vec3d p = anywhere(r), d = anywhere(r);
         return Points{anywhere(r), p, along(p, d, r), along(p, d, r)};
       }},
      {"a triangle with two corners in one", QueryKind::kVertexTriangle,
       [](Random& r) {
         const Vec3d p = anywhere(r), q = anywhere(r);
         return r.chance(0.5) ? Points{anywhere(r), p, p, q} : Points{anywhere(r), p, q, q};
       }},
      {"a triangle that is a point", QueryKind::kVertexTriangle,
       [](Random& r) {
         const Vec3d p = anywhere(r);
         return Points{anywhere(r), p, p, p};
       }},
  };
  return all;
}

/// As the scalar type holds them.
template <class Real>
Points rounded(Points points) {
  for (Vec3d& p : points)
    for (double& x : p) x = static_cast<Real>(x);
  return points;
}

double distance_of(QueryKind kind, const Points& p) {
  return kind == QueryKind::kEdgeEdge ? edge_edge({p[0], p[1]}, {p[2], p[3]}).distance
                                      : point_triangle(p[0], {p[1], p[2], p[3]}).distance;
}

/// Features whose distance is known to within a hundredth, by the judge.
template <class Real>
std::vector<std::pair<Points, double>> measured(const Family& family) {
  Random random(19);
  std::vector<std::pair<Points, double>> all;
  for (int i = 0; i < kQueriesOfFamily; ++i) {
    const Points points = rounded<Real>(family.make(random));
    const double distance = distance_of(family.kind, points);
    if (distance < 1e-3) continue;  // within float's doubts
    EXPECT_FALSE(judge_proximity(family.kind, points, 0.99 * distance)) << family.name << " " << i;
    EXPECT_TRUE(judge_proximity(family.kind, points, 1.01 * distance)) << family.name << " " << i;
    all.emplace_back(points, distance);
  }
  EXPECT_GT(all.size(), size_t{kQueriesOfFamily / 2}) << family.name;
  return all;
}

template <class Work, class Real, class Kind>
bool told_apart(const Points& points, double thickness) {
  FeaturePoints<Real> features;
  for (int i = 0; i < 4; ++i)
    features.start[i] = features.end[i] = {static_cast<Real>(points[i][0]), static_cast<Real>(points[i][1]),
                                           static_cast<Real>(points[i][2])};
  DifferencesOf<Work, Kind> d;
  return load_differences<Kind, Work>(features, d) && are_apart(d, scaled_thickness<Work>(thickness, d.scale));
}

template <class Types>
class DegenerateDistance : public testing::Test {};

template <class A, class B>
struct Precisions {
  using Work = A;
  using Real = B;
};
using AllPrecisions = testing::Types<Precisions<float, float>, Precisions<float, double>, Precisions<double, double>>;
TYPED_TEST_SUITE(DegenerateDistance, AllPrecisions);

TYPED_TEST(DegenerateDistance, TellsApartWhatIsAndNothingElse) {
  using Work = typename TypeParam::Work;
  using Real = typename TypeParam::Real;
  for (const Family& family : families()) {
    const auto told = family.kind == QueryKind::kEdgeEdge ? &told_apart<Work, Real, EdgeEdge>
                                                          : &told_apart<Work, Real, VertexTriangle>;
    size_t near = 0, lost = 0;
    for (const auto& [points, distance] : measured<Real>(family)) {
      near += told(points, 0.9 * distance) ? 0 : 1;
      lost += told(points, 1.1 * distance) ? 1 : 0;
    }
    EXPECT_EQ(near, 0u) << family.name << ": not told apart at 0.9 of their distance";
    EXPECT_EQ(lost, 0u) << family.name << ": told apart at 1.1 of their distance";
  }
}

// The same through the narrow phase, one thickness for each query.
TEST(DegenerateContacts, AreThoseWithinTheThickness) {
  for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact})
    for (const Family& family : families())
      for (const auto& [points, distance] : measured<float>(family)) {
        Query query{family.kind, {}};
        for (size_t i = 0; i < 4; ++i) query.p[i] = query.p[4 + i] = points[i];
        for (const double of_distance : {0.9, 1.1}) {
          const BatchSettings settings{Backend::kCpu, Mode::kDcd, Scalar::kF32, accuracy, 0, of_distance * distance};
          const Verdict verdict = run_queries({&query, 1}, settings).at(0);
          ASSERT_EQ(verdict.hit, of_distance > 1) << family.name << ", level " << static_cast<int>(accuracy);
        }
      }
}

}  // namespace
}  // namespace collided::test
