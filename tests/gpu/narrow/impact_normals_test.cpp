// Normals of impacts oppose the approach, at every level that has guarantees, however the features move.

#include "gpu/narrow/normal.hpp"
#include "tests/gpu/backend.hpp"
#include "tests/support/distance.hpp"
#include "tests/support/families/near_misses.hpp"
#include "tests/support/families/query_families_shapes.hpp"
#include "tests/support/verdicts/verdict_score_question.hpp"

namespace collided::test {
namespace {

Closest closest_at(const Query& query, double t) {
  std::array<Vec3d, 4> p;
  for (size_t k = 0; k < 4; ++k) p[k] = lerp(query.p[k], query.p[k + 4], t);
  if (query.kind == QueryKind::kVertexTriangle) return point_triangle(p[0], {p[1], p[2], p[3]});
  return edge_edge({p[0], p[1]}, {p[2], p[3]});
}

/// Motion of the first feature's closest point against the second's in the whole step, for what is at time t.
std::array<mpq_class, 3> motion_at(const Query& query, double t) {
  const auto [w0, w1] = closest_at(query, t).weights;
  const mpq_class x(w0), y(w1);
  const bool vertex = query.kind == QueryKind::kVertexTriangle;
  const std::array<mpq_class, 4> weights =
      vertex ? std::array<mpq_class, 4>{1, x + y - 1, -x, -y} : std::array<mpq_class, 4>{1 - x, x, y - 1, -y};
  std::array<mpq_class, 3> motion;
  for (size_t v = 0; v < 4; ++v)
    for (size_t k = 0; k < 3; ++k) motion[k] += weights[v] * (mpq_class(query.p[v + 4][k]) - mpq_class(query.p[v][k]));
  return motion;
}

/// Returns how fast the distance shrinks before t: the least of several mean speeds, and so 0 for grazing features.
double approach_speed(const Query& query, double t, double shortest) {
  const double now = closest_at(query, t).distance;
  double least = 1e300;
  for (double before = shortest; before <= 64 * shortest; before *= 4)
    least = std::min(least, before <= t ? (closest_at(query, t - before).distance - now) / before : 0);
  return least;
}

Normal normal_of(const Query& query, double toi) {
  FeaturePoints<double> points;
  for (size_t k = 0; k < 4; ++k) {
    points.start[k] = {query.p[k][0], query.p[k][1], query.p[k][2]};
    points.end[k] = {query.p[k + 4][0], query.p[k + 4][1], query.p[k + 4][2]};
  }
  if (query.kind == QueryKind::kVertexTriangle) return contact_normal<VertexTriangle>(points, toi, kClear);
  return contact_normal<EdgeEdge>(points, toi, kClear);
}

struct Tally {
  uint64_t impacts = 0, wrong = 0;
};

/// Scales the query by a power of two to an extent of 1 to 2.
Query in_own_units(Query query) {
  const double extent = extent_of(query);
  if (extent == 0) return query;
  for (Vec3d& p : query.p)
    for (double& x : p) x = std::ldexp(x, -std::ilogb(extent));
  return query;
}

/// Edges that are parallel but for a little, or slivers: where they touch is beyond double precision.
bool are_nearly_parallel(const Query& query, double t) {
  std::array<Vec3d, 4> p;
  for (size_t k = 0; k < 4; ++k) p[k] = lerp(query.p[k], query.p[k + 4], t);
  const bool vertex = query.kind == QueryKind::kVertexTriangle;
  const Vec3d d = vertex ? minus(p[2], p[1]) : minus(p[1], p[0]), e = vertex ? minus(p[3], p[1]) : minus(p[3], p[2]);
  const Vec3d n{d[1] * e[2] - d[2] * e[1], d[2] * e[0] - d[0] * e[2], d[0] * e[1] - d[1] * e[0]};
  const double sine = length_between(n, {}) / (length_between(d, {}) * length_between(e, {}));
  return sine > 0 && sine < 0x1p-12;
}

/// True if the time that was reported is that of the impact, and not of a near miss before it.
bool is_of_impact(const Query& query, const Verdict& verdict) {
  if (!verdict.hit || verdict.toi == 0) return false;
  const ExactImpact truth = judge_ccd(query);
  return truth.hit && truth.upper.get_d() - verdict.toi < 0x1p-12;
}

/// Counts impacts at an angle that is not too flat, and those whose normal does not oppose the approach.
Tally tally(const std::vector<Query>& queries, Accuracy accuracy) {
  Tally tally;
  const auto verdicts = run_queries(queries, {kBackend, Mode::kCcd, Scalar::kF64, accuracy});
  const double shortest = accuracy == Accuracy::kGuarded ? 0x1p-12 : 0x1p-24;
  for (size_t i = 0; i < queries.size(); ++i) {
    if (!is_of_impact(queries[i], verdicts[i])) continue;
    const Query query = in_own_units(queries[i]);
    if (are_nearly_parallel(query, verdicts[i].toi)) continue;
    const auto motion = motion_at(query, verdicts[i].toi);
    double length = 0;
    for (const mpq_class& x : motion) length += x.get_d() * x.get_d();
    length = std::sqrt(length);
    if (length < 0x1p-20 || approach_speed(query, verdicts[i].toi, shortest) < length / 64) continue;
    const Normal n = normal_of(queries[i], verdicts[i].toi);
    mpq_class along = 0;
    for (size_t k = 0; k < 3; ++k) along += motion[k] * mpq_class(n[k]);
    ++tally.impacts;
    tally.wrong += along.get_d() > -0x1p-11 * length;
  }
  return tally;
}

class ImpactNormals : public OnBackend<::testing::TestWithParam<Accuracy>> {};

TEST_P(ImpactNormals, OpposeTheApproachInAPlaneAndInSlides) {
  uint64_t impacts = 0;
  for (const NearMissFamily family : kNearMissFamilies)
    for (const QueryKind kind : kQueryKinds) {
      Random random(3);
      std::vector<Query> queries;
      for (int i = 0; i < 1500; ++i) queries.push_back(near_miss(family, kind, 0, random));
      const Tally found = tally(queries, GetParam());
      SCOPED_TRACE(name_of(family) + " " + name_of(kind));
      EXPECT_EQ(found.wrong, 0u) << "of " << found.impacts;
      impacts += found.impacts;
    }
  EXPECT_GT(impacts, 400u);
}

// Lattices, coplanar and parallel features, slivers, points: all that tends to fail.
TEST_P(ImpactNormals, OpposeTheApproachInDegenerateFamilies) {
  uint64_t impacts = 0;
  for (const QueryFamily& family : fuzz_families())
    for (const QueryKind kind : kQueryKinds) {
      const Tally found = tally(queries_of({&family, kind, Scalar::kF64, 5}, 300), GetParam());
      SCOPED_TRACE(family.name + " " + name_of(kind));
      EXPECT_EQ(found.wrong, 0u) << "of " << found.impacts;
      impacts += found.impacts;
    }
  EXPECT_GT(impacts, 500u);
}

INSTANTIATE_TEST_SUITE_P(Levels, ImpactNormals,
                         ::testing::Values(Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact),
                         [](const auto& info) { return name_of(info.param); });

}  // namespace
}  // namespace collided::test
