// Queries in large numbers: the levels' promises hold in CCD, with a thickness, and in DCD.

#include "tests/support/verdicts/verdict_score_checks.hpp"

namespace collided::test {
namespace {

ScoreFile& score_file() {
  static auto* file = new ScoreFile("COLLIDED_FUZZ_OUT");  // GoogleTest deletes it
  return *file;
}
const auto* const kRegistered = ::testing::AddGlobalTestEnvironment(&score_file());

class AccuracyFuzz : public OnBackend<::testing::TestWithParam<FamilyCase>> {
 protected:
  // A fraction of the queries that COLLIDED_FUZZ_QUERIES requests; by default the size for CI.
  static Question question(QueryKind kind, uint64_t parts) {
    const auto [family, scalar] = GetParam();
    const uint64_t seed = number_from_environment("COLLIDED_FUZZ_SEED", 1);
    return {{family, kind, scalar, seed}, number_from_environment("COLLIDED_FUZZ_QUERIES", 500) / parts};
  }
};

TEST_P(AccuracyFuzz, LevelsKeepTheirPromises) {
  for (QueryKind kind : kQueryKinds) expect_promises(question(kind, 1), &score_file().table);
}

TEST_P(AccuracyFuzz, AlsoWithAThickness) {
  for (QueryKind kind : kQueryKinds) {
    for (double share : {0.1, 0x1p-30, 0x1p30}) {
      Question q = question(kind, 20);
      q.thickness_share = share;
      expect_promises(q);
    }
  }
}

TEST_P(AccuracyFuzz, AlsoInOneFrame) {
  for (QueryKind kind : kQueryKinds) {
    for (double share : {0.2, 0x1p-30, 0x1p30}) {
      Question q = question(kind, 2);
      q.mode = Mode::kDcd;
      q.thickness_share = share;
      expect_promises(q);
    }
  }
}

// Reporting everything at t = 0 would break no promise of GUARDED and CERTIFIED: on queries that are not contrived they
// must also be sharp. The bounds are a few times the measured values.
class Sharpness : public OnBackend<::testing::TestWithParam<std::tuple<Scalar, QueryKind>>> {
 protected:
  static Score score_on(const char* family, Accuracy accuracy) {
    const auto [scalar, kind] = GetParam();
    return score_of({{&fuzz_family(family), kind, scalar, 5}, 1000}, accuracy);
  }
};

TEST_P(Sharpness, FewHitsAreFalseOnOrdinaryQueries) {
  for (Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified})
    EXPECT_LE(score_on("anything", accuracy).false_hits, 3u) << name_of(accuracy);
  EXPECT_LE(score_on("lattice", Accuracy::kCertified).false_hits, 3u);
}

TEST_P(Sharpness, TimesAreEarlyByAboutDelta) {
  const Score guarded = score_on("anything", Accuracy::kGuarded),
              certified = score_on("anything", Accuracy::kCertified);
  EXPECT_GT(guarded.hits, 50u);
  EXPECT_LE(guarded.median_gap(), 1e-5);
  EXPECT_LE(guarded.worst_gap(), 1e-2);
  EXPECT_LE(certified.median_gap(), 1e-13);
  EXPECT_LE(certified.worst_gap(), 1e-2);
}

TEST_P(Sharpness, MostOrdinaryHitsAreCertified) {
  const Score certified = score_on("anything", Accuracy::kCertified);
  EXPECT_GE(certified.certified, certified.hits * 9 / 10);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Sharpness,
                         ::testing::Combine(::testing::Values(Scalar::kF32, Scalar::kF64),
                                            ::testing::ValuesIn(kQueryKinds)),
                         [](const auto& info) {
                           return name_of(std::get<0>(info.param)) + "_" + name_of(std::get<1>(info.param));
                         });
INSTANTIATE_TEST_SUITE_P(Families, AccuracyFuzz, ::testing::ValuesIn(cases_of(fuzz_families())),
                         [](const auto& info) { return case_name(info.param); });

}  // namespace
}  // namespace collided::test
