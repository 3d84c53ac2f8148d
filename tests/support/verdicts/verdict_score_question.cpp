#include "tests/support/verdicts/verdict_score_question.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace collided::test {
namespace {

double thickness_of(const std::vector<Query>& queries, double share) {
  if (share == 0) return 0;
  const double wanted = share * typical_extent(queries);
  const double power = wanted > 0 ? std::ldexp(1.0, std::ilogb(wanted)) : 0;
  return std::max(power, std::numeric_limits<double>::denorm_min());
}

}  // namespace

Judged judged(const Question& question) {
  std::vector<Query> queries = queries_of(question.source, question.count);
  const double thickness = thickness_of(queries, question.thickness_share);
  return judge(std::move(queries), question.mode, thickness);
}

std::vector<FamilyCase> cases_of(const std::vector<QueryFamily>& families) {
  std::vector<FamilyCase> cases;
  for (const QueryFamily& family : families) {
    if (!family.f64_only) cases.push_back({&family, Scalar::kF32});
    cases.push_back({&family, Scalar::kF64});
  }
  return cases;
}

std::string case_name(const FamilyCase& family_case) {
  std::string name;
  bool upper = true;
  for (char c : std::get<0>(family_case)->name) {
    if (c == '-') name += "Minus";
    if (std::isalnum(static_cast<unsigned char>(c))) name += upper ? static_cast<char>(std::toupper(c)) : c;
    upper = !std::isalnum(static_cast<unsigned char>(c));
  }
  return name + "_" + name_of(std::get<1>(family_case));
}

uint64_t number_from_environment(const char* name, uint64_t otherwise) {
  const char* value = std::getenv(name);
  return value ? std::strtoull(value, nullptr, 10) : otherwise;
}

}  // namespace collided::test
