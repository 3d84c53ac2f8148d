#pragma once
// The settings and the number of queries with which a test uses a family.

#include <string>
#include <tuple>
#include <vector>

#include "tests/support/families/query_families.hpp"
#include "tests/support/verdicts/verdict_score.hpp"

namespace collided::test {

struct Question {
  QuerySource source;
  uint64_t count = 0;
  Mode mode = Mode::kCcd;
  double thickness_share = 0;  ///< of the queries' typical extent
};

/// The question's queries with their truth. The thickness is a power of two, so that on integers it is met exactly.
Judged judged(const Question& question);

inline constexpr QueryKind kQueryKinds[] = {QueryKind::kVertexTriangle, QueryKind::kEdgeEdge};

/// A family on a scalar type, as a parameter of tests.
using FamilyCase = std::tuple<const QueryFamily*, Scalar>;
std::vector<FamilyCase> cases_of(const std::vector<QueryFamily>& families);

/// Names the case with letters, digits and underscores only.
std::string case_name(const FamilyCase& family_case);

/// The value of an environment variable, or a default.
uint64_t number_from_environment(const char* name, uint64_t otherwise);

}  // namespace collided::test
