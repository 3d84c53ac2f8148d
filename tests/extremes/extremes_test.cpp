// Every family on which the usual methods fail: the levels' promises hold in CCD, with a thickness, and in DCD.

#include "tests/support/verdicts/verdict_score_checks.hpp"

namespace collided::test {
namespace {

ScoreFile& score_file() {
  static auto* file = new ScoreFile("COLLIDED_EXTREMES_OUT");  // GoogleTest deletes it
  return *file;
}
const auto* const kRegistered = ::testing::AddGlobalTestEnvironment(&score_file());

class Extremes : public OnBackend<::testing::TestWithParam<FamilyCase>> {
 protected:
  static Question question(QueryKind kind) {
    const auto [family, scalar] = GetParam();
    return {{family, kind, scalar, 1}, number_from_environment("COLLIDED_EXTREMES_QUERIES", 150)};
  }
};

TEST_P(Extremes, LevelsKeepTheirPromises) {
  for (QueryKind kind : kQueryKinds) expect_promises(question(kind), &score_file().table);
}

TEST_P(Extremes, AlsoWithAThickness) {
  for (QueryKind kind : kQueryKinds) {
    Question q = question(kind);
    q.count /= 5;
    q.thickness_share = 0.05;
    expect_promises(q);
  }
}

TEST_P(Extremes, AlsoInOneFrame) {
  for (QueryKind kind : kQueryKinds) {
    Question q = question(kind);
    q.mode = Mode::kDcd;
    q.thickness_share = 0.1;
    expect_promises(q);
  }
}

INSTANTIATE_TEST_SUITE_P(Families, Extremes, ::testing::ValuesIn(cases_of(extreme_families())),
                         [](const auto& info) { return case_name(info.param); });

}  // namespace
}  // namespace collided::test
