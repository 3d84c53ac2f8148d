// The narrow phase at every accuracy against the judge: what tests/fuzz promises of the levels.

#include <algorithm>
#include <cmath>

#include "gpu/positions/format.hpp"
#include "tests/fuzz/targets/query_input.hpp"
#include "tests/support/families/query_families.hpp"
#include "tests/support/verdicts/verdict_score.hpp"

namespace collided::fuzz {
namespace {

using namespace test;  // NOLINT: the judge's side

void check(const Judged& truth, const BatchSettings& settings) {
  std::vector<Offence> offences;
  score(truth, run_queries(truth.queries, settings), settings.accuracy, &offences);
  if (!offences.empty())
    require(false, name_of(settings.accuracy) + ": " + offences[0].what + "\n  " + text_of(truth.queries[0]));
}

// What a scene takes.
bool is_valid(const Query& query, const BatchSettings& settings) {
  const double limit = coordinate_limit(settings.scalar);
  const auto fits = [&](double x) { return std::abs(x) <= limit; };
  return fits(settings.thickness) && std::all_of(query.p.begin(), query.p.end(), [&](const Vec3d& point) {
           return std::all_of(point.begin(), point.end(), fits);
         });
}

BatchSettings settings_of(Input& input, const Head& head) {
  BatchSettings settings;
  settings.scalar = head.rest & 1 ? Scalar::kF32 : Scalar::kF64;
  settings.mode = head.rest & 2 ? Mode::kDcd : Mode::kCcd;
  if (head.rest & 4) settings.thickness = static_cast<float>(std::abs(coordinate(input, head.how)));
  if (settings.mode == Mode::kDcd && settings.thickness == 0) settings.thickness = 1;
  return settings;
}

}  // namespace

void run(Input input) {
  const Head head(input.number<uint8_t>());
  Query query{head.kind, {}};
  read_points(input, head.how, query.p);
  BatchSettings settings = settings_of(input, head);
  query = rounded(query, settings.scalar);
  if (!is_valid(query, settings)) return;
  const Judged truth = judge({query}, settings.mode, settings.thickness);
  for (const Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact}) {
    settings.accuracy = accuracy;
    check(truth, settings);
  }
}

}  // namespace collided::fuzz
