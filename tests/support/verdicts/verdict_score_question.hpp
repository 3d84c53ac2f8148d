#pragma once
// What a test asks of a family of queries, and how much of it.

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

/// The queries of the question with what is true of them. The thickness is a power of two, so that on integers it is
/// met exactly.
Judged judged(const Question& question);

inline constexpr QueryKind kQueryKinds[] = {QueryKind::kVertexTriangle, QueryKind::kEdgeEdge};

/// A family on a scalar type, as a parameter of tests.
using FamilyCase = std::tuple<const QueryFamily*, Scalar>;
std::vector<FamilyCase> cases_of(const std::vector<QueryFamily>& families);

/// Names the case with letters, digits and an underscore alone.
std::string case_name(const FamilyCase& family_case);

/// The value of an environment variable, or another one where it is not set.
uint64_t number_from_environment(const char* name, uint64_t otherwise);

}  // namespace collided::test
