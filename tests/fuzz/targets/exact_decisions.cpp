// The engine's exact decisions against the judge, which shares no code with them.

#include "gpu/exact/exact.hpp"
#include "tests/fuzz/agreement.hpp"
#include "tests/fuzz/targets/query_input.hpp"

namespace collided::fuzz {
namespace {

using test::Corners;
using test::Query;

double thickness_of(Input& input, Coordinates how) { return std::abs(coordinate(input, how)); }

void first_contact(const Query& query, double thickness) {
  Corners start, end;
  test::corners_of(query, 0, start);
  test::corners_of(query, 4, end);
  const ContactKind kind = test::contact_kind_of(query);
  const test::ExactImpact truth = thickness > 0 ? test::judge_ccd(query, thickness) : test::judge_ccd(query);
  const collided::ExactImpact impact = exact_ccd(kind, start, end, thickness);
  require(impact.hit == truth.hit, "engine and judge agree on a hit");
  if (truth.hit) require(test::time_agrees(impact.toi, truth), "engine and judge agree on its time");
  if (truth.hit) require(impact.initial == (truth.upper == 0), "engine and judge agree on contact at t = 0");
  if (thickness > 0) return;
  using exact::fixed::Outcome;
  const exact::fixed::Verdict verdict = exact::fixed::decide(kind, start, end);
  if (verdict.outcome == Outcome::kOpen) return;
  require((verdict.outcome != Outcome::kApart) == truth.hit, "fixed integers and judge agree on a hit");
  if (truth.hit) require(test::time_agrees(verdict.toi, truth), "fixed integers and judge agree on its time");
}

void proximity(const Query& query, double thickness) {
  Corners corners;
  test::corners_of(query, 0, corners);
  const bool truth = test::judge_proximity(query.kind, {query.p[0], query.p[1], query.p[2], query.p[3]}, thickness);
  require(exact_proximity(test::contact_kind_of(query), corners, thickness) == truth,
          "engine and judge agree on proximity");
}

void triangles(const Query& query) {
  Vec3<double> a[3], b[3];
  const auto corner = [&](size_t i) { return Vec3<double>{query.p[i][0], query.p[i][1], query.p[i][2]}; };
  for (size_t i = 0; i < 3; ++i) a[i] = corner(i), b[i] = corner(3 + i);
  const bool truth = test::judge_triangles({query.p[0], query.p[1], query.p[2]}, {query.p[3], query.p[4], query.p[5]});
  require(exact_triangles_intersect(a, b) == truth, "engine and judge agree on two triangles");
  b[0] = a[0];
  const bool beyond =
      test::judge_neighbours({query.p[0], query.p[1], query.p[2]}, {query.p[0], query.p[4], query.p[5]});
  require(exact_triangles_meet_beyond_corner(a, b) == beyond, "engine and judge agree on neighbours");
}

}  // namespace

void run(Input input) {
  const Head head(input.number<uint8_t>());
  Query query{head.kind, {}};
  read_points(input, head.how, query.p);
  switch (head.rest % 4) {
    case 0:
      return first_contact(query, 0);
    case 1:
      return first_contact(query, thickness_of(input, head.how));
    case 2:
      return proximity(query, thickness_of(input, head.how));
    default:
      return triangles(query);
  }
}

}  // namespace collided::fuzz
