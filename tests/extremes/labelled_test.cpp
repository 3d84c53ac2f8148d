// Queries and pairs of real frames, labelled by others and by us: verdicts of the levels, and that CERTIFIED reports
// fewer false contacts than usual methods.

#include "tests/support/labelled/labelled.hpp"

#include <cmath>
#include <cstdio>
#include <limits>

#include "tests/gpu/backend.hpp"
#include "tests/support/data_folder.hpp"
#include "tests/support/families/query_families.hpp"
#include "tests/support/frames/frame_truth.hpp"
#include "tests/support/verdicts/verdict_score.hpp"

namespace collided::test {
namespace {

class Labelled : public OnBackend<::testing::TestWithParam<Scalar>> {
 protected:
  /// The queries of each kind with their truth. Rounded to float, they are judged again: labels hold for double.
  static std::vector<Judged> judged(const std::vector<LabelledQuery>& labelled) {
    std::vector<Judged> kinds;
    for (QueryKind kind : {QueryKind::kVertexTriangle, QueryKind::kEdgeEdge}) {
      std::vector<Query> queries;
      for (const LabelledQuery& l : labelled)
        if (l.query.kind == kind && fits(l.query)) queries.push_back(rounded(l.query, GetParam()));
      kinds.push_back(judge(std::move(queries), Mode::kCcd, 0));
    }
    return kinds;
  }

  static Score score_of(const std::vector<Judged>& kinds, Accuracy accuracy) {
    BatchSettings settings;
    settings.backend = kBackend;
    settings.scalar = GetParam();
    settings.accuracy = accuracy;
    Score sum;
    for (const Judged& kind : kinds) sum += score(kind, run_queries(kind.queries, settings), accuracy);
    return sum;
  }

  /// Checks every level; returns the false contacts of CERTIFIED.
  static uint64_t expect_promises(const char* what, const std::vector<LabelledQuery>& labelled) {
    const std::vector<Judged> kinds = judged(labelled);
    uint64_t false_at_certified = 0;
    for (Accuracy accuracy : {Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact}) {
      const Score s = score_of(kinds, accuracy);
      std::printf("%s, %s, %s: %llu queries, %llu hits, %llu missed, %llu late, %llu false, %llu certified\n", what,
                  name_of(GetParam()).c_str(), name_of(accuracy).c_str(), number(s.queries), number(s.hits),
                  number(s.missed), number(s.late), number(s.false_hits), number(s.certified));
      if (accuracy == Accuracy::kCertified) false_at_certified = s.false_hits;
      if (accuracy == Accuracy::kFast) continue;
      EXPECT_EQ(s.missed + s.late + s.wrongly_certified + s.wrong_initial + s.malformed, 0u) << name_of(accuracy);
      EXPECT_TRUE(accuracy != Accuracy::kExact || s.false_hits == 0);
    }
    return false_at_certified;
  }

 private:
  /// Whether the scalar type has numbers of that size.
  static bool fits(const Query& query) {
    const double most = GetParam() == Scalar::kF32 ? std::numeric_limits<float>::max() / 8 : HUGE_VAL;
    for (const Vec3d& p : query.p)
      for (const double x : p)
        if (std::abs(x) > most) return false;
    return true;
  }
  static unsigned long long number(uint64_t n) { return n; }
};

TEST_P(Labelled, OurOwnSet) { expect_promises("own set", read_labelled_set(labelled_set())); }

TEST_P(Labelled, HandMadeQueries) {
  const auto data = data_folder();
  if (!data) GTEST_SKIP() << kNoDataFolder;
  std::vector<LabelledQuery> all;
  for (const std::string& set : query_sets(*data)) {
    const auto queries = read_query_set(*data, set);
    all.insert(all.end(), queries.begin(), queries.end());
  }
  // Tight-Inclusion at tolerance 1e-6 reports 222 false contacts on ten sets; these are seven of them and one more.
  const uint64_t false_hits = expect_promises("hand-made queries", all);
  EXPECT_TRUE(GetParam() == Scalar::kF32 || false_hits <= 222);
}

TEST_P(Labelled, PairsOfOurOwnFrames) { expect_promises(kDrapeFrames.name, read_frame_queries(kDrapeFrames)); }

TEST_P(Labelled, PairsOfRealFrames) {
  if (!data_folder()) GTEST_SKIP() << kNoDataFolder;
  for (const RealFrames& frames : {kFunnelFrames, kBallFrames})
    expect_promises(frames.name, read_frame_queries(frames));
}

INSTANTIATE_TEST_SUITE_P(Scalars, Labelled, ::testing::Values(Scalar::kF32, Scalar::kF64),
                         [](const auto& info) { return name_of(info.param); });

}  // namespace
}  // namespace collided::test
