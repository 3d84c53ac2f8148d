// The engine's exact decisions against the judge, which shares no code with them, on all families.

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <map>

#include "gpu/exact/exact.hpp"
#include "tests/fuzz/agreement.hpp"
#include "tests/support/verdicts/verdict_score_question.hpp"

namespace collided::test {
namespace {

collided::ExactImpact decide_ccd(const Query& query, double thickness) {
  Corners start, end;
  corners_of(query, 0, start);
  corners_of(query, 4, end);
  return exact_ccd(contact_kind_of(query), start, end, thickness);
}

bool decide_proximity(const Query& query, double thickness) {
  Corners end;
  corners_of(query, 4, end);
  return exact_proximity(contact_kind_of(query), end, thickness);
}

// How the engine's answer differs from the judge's; empty if it does not.
std::string disagreement(const Judged& judged, size_t i) {
  const Query& query = judged.queries[i];
  const ExactImpact& truth = judged.truth[i];
  if (judged.mode == Mode::kDcd) return decide_proximity(query, judged.thickness) == truth.hit ? "" : "hit or not";
  const collided::ExactImpact impact = decide_ccd(query, judged.thickness);
  if (impact.hit != truth.hit) return "hit or not";
  return !truth.hit || time_agrees(impact.toi, truth) ? "" : "time " + ::testing::PrintToString(impact.toi);
}

void expect_agreement(const Question& question) {
  const Judged truth = judged(question);
  std::vector<std::string> wrong(truth.queries.size());
  tbb::parallel_for(size_t{0}, wrong.size(), [&](size_t i) { wrong[i] = disagreement(truth, i); });
  for (size_t i = 0; i < wrong.size(); ++i) {
    EXPECT_EQ(wrong[i], "") << question.source.family->name << ", query " << i
                            << "\n  truth: " << text_of(truth.truth[i]) << "\n  thickness " << truth.thickness << "\n  "
                            << text_of(truth.queries[i]);
  }
}

class ExactAgreement : public ::testing::TestWithParam<FamilyCase> {
 protected:
  static Question question(QueryKind kind, uint64_t parts) {
    const auto [family, scalar] = GetParam();
    const uint64_t seed = number_from_environment("COLLIDED_FUZZ_SEED", 1) + 100;
    return {{family, kind, scalar, seed}, number_from_environment("COLLIDED_FUZZ_QUERIES", 500) / parts};
  }
};

TEST_P(ExactAgreement, FirstContact) {
  for (QueryKind kind : kQueryKinds) expect_agreement(question(kind, 5));
}

TEST_P(ExactAgreement, FirstTimeWithinAThickness) {
  for (QueryKind kind : kQueryKinds) {
    Question q = question(kind, 20);
    q.thickness_share = 0.1;
    expect_agreement(q);
  }
}

TEST_P(ExactAgreement, Proximity) {
  for (QueryKind kind : kQueryKinds) {
    Question q = question(kind, 5);
    q.mode = Mode::kDcd;
    q.thickness_share = 0.2;
    expect_agreement(q);
  }
}

/// Families with ways of their own, of which many queries meet a thickness of 1/2 exactly.
class ExactAgreementOnCostly : public ::testing::TestWithParam<FamilyCase> {
 protected:
  static uint64_t queries() { return number_from_environment("COLLIDED_FUZZ_QUERIES", 60); }
  static void expect(double thickness, bool is_ccd, uint64_t count) {
    const auto [family, scalar] = GetParam();
    for (QueryKind kind : kQueryKinds)
      for (const Query& query : queries_of({family, kind, scalar, 11}, count)) {
        const std::string wrong = is_ccd ? impact_disagreement(query, thickness) : rest_disagreement(query, thickness);
        EXPECT_EQ(wrong, "") << family->name << ", thickness " << thickness << "\n  " << text_of(query);
      }
  }

 private:
  static std::string impact_disagreement(const Query& query, double thickness) {
    const ExactImpact truth = judge_ccd(query, thickness);
    const collided::ExactImpact impact = decide_ccd(query, thickness);
    if (impact.hit != truth.hit) return "hit or not";
    return !truth.hit || time_agrees(impact.toi, truth) ? "" : "time " + ::testing::PrintToString(impact.toi);
  }
  static std::string rest_disagreement(const Query& query, double thickness) {
    const bool truth = judge_proximity(query.kind, {query.p[4], query.p[5], query.p[6], query.p[7]}, thickness);
    return decide_proximity(query, thickness) == truth ? "" : "hit or not";
  }
};

TEST_P(ExactAgreementOnCostly, FirstContact) { expect(0, true, queries()); }
TEST_P(ExactAgreementOnCostly, FirstTimeWithinAThickness) { expect(0.5, true, queries() * 2 / 3); }
TEST_P(ExactAgreementOnCostly, Proximity) {
  for (const double thickness : {0.0, 0.5}) expect(thickness, false, queries());
}

/// Which integers decide: of one limb, of two, or of any size; and what they decide.
using Rungs = std::map<std::pair<int, exact::fixed::Outcome>, int>;

void count_rungs(const Query& query, Rungs& rungs) {
  Corners start, end;
  corners_of(query, 0, start);
  corners_of(query, 4, end);
  exact::fixed::Unit unit;
  unit.see(start);
  unit.see(end);
  const int limbs = unit.fits<1>() ? 1 : unit.fits<2>() ? 2 : 0;
  ++rungs[{limbs, exact::fixed::decide(contact_kind_of(query), start, end).outcome}];
}

// So that the tests above are tests of every rung.
TEST(ExactLadder, EveryRungDecidesQueriesOfTheFamilies) {
  using exact::fixed::Outcome;
  Rungs rungs;
  for (const auto& families : {fuzz_families(), extreme_families()})
    for (const auto& [family, scalar] : cases_of(families))
      for (QueryKind kind : kQueryKinds)
        for (const Query& query : queries_of({family, kind, scalar, 3}, 60)) count_rungs(query, rungs);
  for (const int limbs : {1, 2})
    for (const Outcome outcome :
         {Outcome::kOpen, Outcome::kApart, Outcome::kAtStart, Outcome::kBetween, Outcome::kAtEnd})
      EXPECT_GT((rungs[{limbs, outcome}]), 0) << limbs << " limbs, outcome " << static_cast<int>(outcome);
  EXPECT_GT((rungs[{0, Outcome::kOpen}]), 20) << "exponents far apart";
}

INSTANTIATE_TEST_SUITE_P(Fuzz, ExactAgreement, ::testing::ValuesIn(cases_of(fuzz_families())),
                         [](const auto& info) { return case_name(info.param); });
INSTANTIATE_TEST_SUITE_P(Costly, ExactAgreementOnCostly, ::testing::ValuesIn(cases_of(costly_families())),
                         [](const auto& info) { return case_name(info.param); });
INSTANTIATE_TEST_SUITE_P(Extremes, ExactAgreement, ::testing::ValuesIn(cases_of(extreme_families())),
                         [](const auto& info) { return case_name(info.param); });

}  // namespace
}  // namespace collided::test
