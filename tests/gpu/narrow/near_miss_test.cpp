// CERTIFIED is as sharp as proto/ACCURACY.md states where features slide past each other or move in one plane. Integer
// arithmetic decides each query.

#include <tbb/parallel_for.h>

#include <atomic>

#include "tests/gpu/backend.hpp"
#include "tests/support/families/near_misses.hpp"
#include "tests/support/families/query_families_shapes.hpp"
#include "tests/support/verdicts/verdict_score_question.hpp"

namespace collided::test {
namespace {

constexpr double kSharpness = 0x1p-46;  ///< of a pair's size

/// The largest component of the vectors from the second feature's vertices to the first's, at both ends of the step.
double size_of(const Query& query) {
  const size_t second = first_feature(query.kind);
  double size = 0;
  for (size_t i = 0; i < second; ++i)
    for (size_t j = second; j < 4; ++j)
      for (size_t time : {0, 4})
        for (size_t k = 0; k < 3; ++k) size = std::max(size, std::abs(query.p[i + time][k] - query.p[j + time][k]));
  return size;
}

struct NearMissCase {
  NearMissFamily family;
  double thickness;
};
void PrintTo(const NearMissCase& c, std::ostream* out) {
  *out << name_of(c.family) << (c.thickness > 0 ? "Thick" : "");
}

using NearMisses = OnBackend<::testing::TestWithParam<NearMissCase>>;

TEST_P(NearMisses, AreReportedWithinTheStatedBoundAlone) {
  const auto [family, thickness] = GetParam();
  const uint64_t count = number_from_environment("COLLIDED_NEAR_MISSES", 3000) / 2;
  for (const QueryKind kind : kQueryKinds) {
    Random random(kind == QueryKind::kVertexTriangle ? 1 : 2);
    std::vector<Query> queries;
    for (uint64_t i = 0; i < count; ++i) queries.push_back(near_miss(family, kind, thickness, random));
    const auto verdicts =
        run_queries(queries, {kBackend, Mode::kCcd, Scalar::kF64, Accuracy::kCertified, 0, thickness});
    std::atomic<uint64_t> reported = 0, contacts = 0, missed = 0, late = 0, blunt = 0, capped = 0;
    tbb::parallel_for(size_t{0}, queries.size(), [&](size_t i) {
      const Query& query = queries[i];
      const Verdict& verdict = verdicts[i];
      const ExactImpact truth = thickness > 0 ? judge_ccd(query, thickness) : judge_ccd(query);
      const mpq_class toi(verdict.toi);
      contacts += truth.hit, reported += verdict.hit;
      missed += truth.hit && !verdict.hit;
      late += truth.hit && verdict.hit && toi > truth.upper;
      if (!verdict.hit || (truth.hit && toi >= truth.lower)) return;
      if ((verdict.flags & kFlagCapped) != 0) return void(++capped);
      // They must come that close by the time that was reported.
      const ExactImpact close = judge_ccd(query, thickness + kSharpness * size_of(query));
      blunt += !close.hit || close.lower > toi;
    });
    SCOPED_TRACE(name_of(kind));
    EXPECT_EQ(missed, 0u);
    EXPECT_EQ(late, 0u);
    EXPECT_EQ(blunt, 0u) << "reported earlier than they come within 2^-46 of their size";
    EXPECT_LE(capped, count / 100);
    EXPECT_GE(contacts, count / 50) << "too few contacts for times to count";
    EXPECT_GE(reported, contacts);
    std::printf("%s %s: %zu queries, %zu contacts, %zu reported, %zu capped\n",
                ::testing::PrintToString(GetParam()).c_str(), name_of(kind).c_str(), size_t{count}, size_t{contacts},
                size_t{reported}, size_t{capped});
  }
}

INSTANTIATE_TEST_SUITE_P(Families, NearMisses,
                         ::testing::Values(NearMissCase{NearMissFamily::kCoplanar, 0},
                                           NearMissCase{NearMissFamily::kNearPlanar, 0},
                                           NearMissCase{NearMissFamily::kSliding, 0},
                                           NearMissCase{NearMissFamily::kGliding, 0},
                                           NearMissCase{NearMissFamily::kCoplanar, 0x1p-10},
                                           NearMissCase{NearMissFamily::kSliding, 0x1p-10}),
                         [](const auto& info) { return ::testing::PrintToString(info.param); });

using NearMissAtRest = OnBackend<>;

// Static features of one plane, 1e-9 of their size apart.
TEST_F(NearMissAtRest, IsNoContactOfADiscreteFrame) {
  Query query{QueryKind::kVertexTriangle, {}};
  const Vec3d out{0.24253562503633297, -0.97014250014533188, 0};
  for (size_t time : {0, 4}) {
    query.p[time] = {0.5 + 1e-9 * out[0], 0.125 + 1e-9 * out[1], 0};
    query.p[time + 1] = {0, 0, 0}, query.p[time + 2] = {1, 0.25, 0}, query.p[time + 3] = {0.25, 1, 0};
  }
  for (Vec3d& p : query.p) p[2] = p[0] + p[1] / 2;
  EXPECT_FALSE(run_queries({&query, 1}, {kBackend, Mode::kDcd})[0].hit);
  EXPECT_FALSE(run_queries({&query, 1}, {kBackend, Mode::kCcd})[0].hit);
}

}  // namespace
}  // namespace collided::test
