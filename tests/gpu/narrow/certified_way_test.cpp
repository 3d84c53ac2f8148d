// Ways that are certified to be free are, and times until which they are certified come before the first approach.
// Integer arithmetic decides.

#include "gpu/narrow/certified_way.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/gpu/narrow/step_scenes.hpp"
#include "tests/support/families/near_misses.hpp"
#include "tests/support/verdicts/verdict_score_question.hpp"

namespace collided::test {
namespace {

struct Counts {
  size_t queries = 0, free = 0, by_normals = 0, truly_free = 0, wrong = 0, late = 0;

  void print(const std::string& what) const {
    std::printf("%s: %zu ways, %zu free, %zu certified, %zu by normals\n", what.c_str(), queries, truly_free, free,
                by_normals);
  }
};

template <class Kind>
void count(const Query& query, double distance, Counts& counts) {
  FeaturePoints<double> points;
  for (size_t i = 0; i < 4; ++i) {
    points.start[i] = {query.p[i][0], query.p[i][1], query.p[i][2]};
    points.end[i] = {query.p[i + 4][0], query.p[i + 4][1], query.p[i + 4][2]};
  }
  DifferencesOf<double, Kind> d;
  ASSERT_TRUE((load_differences<Kind, double>(points, d)));
  const CertifiedWay way = certified_way(d, distance);
  const bool by_normals = normals_separate_all_along(d, scaled_thickness<double>(distance, d.scale));
  const ExactImpact truth = judge_ccd(query, distance);
  ++counts.queries, counts.free += way.is_free, counts.by_normals += by_normals, counts.truly_free += !truth.hit;
  counts.wrong += (way.is_free || by_normals) && truth.hit;
  counts.late += truth.hit && mpq_class(way.until) > truth.upper;
}
void count(const Query& query, double distance, Counts& counts) {
  if (query.kind == QueryKind::kEdgeEdge) return count<EdgeEdge>(query, distance, counts);
  count<VertexTriangle>(query, distance, counts);
}

TEST(CertifiedWays, OfNearMissesAreNeverWrong) {
  const uint64_t each = number_from_environment("COLLIDED_CERTIFIED_WAYS", 300);
  for (const NearMissFamily family : kNearMissFamilies)
    for (const double distance : {0.0, 0x1p-10}) {
      Random random(5);
      Counts counts;
      for (uint64_t i = 0; i < each; ++i)
        for (const QueryKind kind : kQueryKinds) count(near_miss(family, kind, distance, random), distance, counts);
      counts.print(name_of(family) + (distance > 0 ? " at a distance" : ""));
      EXPECT_EQ(counts.wrong, 0u);
      EXPECT_EQ(counts.late, 0u);
      EXPECT_GT(counts.free, each / 10);
    }
}

/// Features of two planes that turn together, `gap` apart at both ends; on the chords between they come nearer.
Query turned_together(QueryKind kind, double gap, double angle, Random& random) {
  Query query{kind, {}};
  const Turn tilt(random.vector(3)), turn(times(angle, random.vector(1)));
  for (size_t i = 0; i < 4; ++i) {
    Vec3d p = random.vector(1);
    p[2] = i < first_feature(kind) ? gap : 0;
    query.p[i] = tilt(p), query.p[i + 4] = turn(query.p[i]);
  }
  return query;
}

TEST(CertifiedWays, OfFeaturesThatTurnTogetherAreNeverWrong) {
  const uint64_t each = number_from_environment("COLLIDED_CERTIFIED_WAYS", 300);
  for (const double gap : {1e-9, 1e-8, 1e-6, 1e-3})
    for (const double angle : {1e-6, 1e-3, 0.1, 1.0}) {
      Random random(6);
      Counts counts;
      for (uint64_t i = 0; i < each; ++i) {
        const QueryKind kind = kQueryKinds[i % 2];
        const double of_gap = random.chance(0.5) ? 0.875 : random.within(0.8, 1);
        count(turned_together(kind, gap, angle, random), of_gap * gap, counts);
      }
      char what[64];
      std::snprintf(what, sizeof(what), "gap %g, turned by %g", gap, angle);
      counts.print(what);
      EXPECT_EQ(counts.wrong, 0u);
      EXPECT_EQ(counts.late, 0u);
      EXPECT_GE(counts.free, counts.by_normals);
      // What keeps 7/8 of its gap is to be known to.
      EXPECT_GT(counts.free, counts.truly_free * 9 / 10) << what;
    }
}

}  // namespace
}  // namespace collided::test
