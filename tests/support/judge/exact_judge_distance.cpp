// Contact at a distance h. The closest points of two features are two vertices, or a vertex and a point strictly inside
// an edge, or points strictly inside a triangle or both edges. Each such part has one polynomial, `gap`, that is
// <= 0 where its lines are within h, and polynomials that are > 0 where its feet are inside.
//
// The distance is continuous: unless it is <= h at t = 0, it is h when it first is <= h. Then the part that holds the
// closest points has gap 0, and this time is a root of its gap: if the gap were 0 at all times, the distance would have
// been h just before, too, with the feet still inside. So only roots of gaps matter.

#include <algorithm>
#include <utility>

#include "tests/support/judge/exact_distance.hpp"

namespace collided::test {
namespace {

struct Part {
  Polynomial gap;                  ///< <= 0: within the thickness
  std::vector<Polynomial> inside;  ///< >= 0: the closest points of the lines or plane are within the features
  Polynomial extent;               ///< > 0: the part is not degenerate; if it is, smaller parts stand in for it
};

Part two_vertices(const ExactQuery& q, int i, int j) {
  const PolynomialVector between = q.x[j] - q.x[i];
  return {dot(between, between) - Polynomial{q.thickness * q.thickness}, {}, Polynomial{1}};
}

Part vertex_and_edge(const ExactQuery& q, const VertexEdge& pair) {
  const PolynomialVector edge = q.x[pair.to] - q.x[pair.from], to_vertex = q.x[pair.vertex] - q.x[pair.from];
  const PolynomialVector area = cross(edge, to_vertex);
  const Polynomial along = dot(edge, to_vertex), square = dot(edge, edge);
  return {dot(area, area) - mpz_class(q.thickness * q.thickness) * square, {along, square - along}, square};
}

Part insides(const ExactQuery& q) {
  Interior interior = interior_of(q);
  const Polynomial square = dot(interior.normal, interior.normal);
  return {interior.f * interior.f - mpz_class(q.thickness * q.thickness) * square, std::move(interior.inside), square};
}

// From the cheapest parts.
std::vector<Part> parts_of(const ExactQuery& q) {
  std::vector<Part> parts;
  const int first = q.kind == QueryKind::kVertexTriangle ? 1 : 2;
  for (int i = 0; i < first; ++i)
    for (int j = first; j < 4; ++j) parts.push_back(two_vertices(q, i, j));
  for (const VertexEdge& pair : vertex_edges(q.kind)) parts.push_back(vertex_and_edge(q, pair));
  parts.push_back(insides(q));
  return parts;
}

bool within_at_start(const Part& part) {
  return part.gap.sign_at_zero() <= 0 && part.extent.sign_at_zero() > 0 &&
         std::ranges::all_of(part.inside, [](const Polynomial& p) { return p.sign_at_zero() >= 0; });
}

// At a root of the gap.
bool is_inside(const Part& part, Root& time) {
  return time.sign_of(part.extent) > 0 &&
         std::ranges::all_of(part.inside, [&](const Polynomial& p) { return time.sign_of(p) >= 0; });
}

// The first of two times of contact; if neither interval is wholly before the other, an interval for the first.
void keep_first(ExactImpact& best, const ExactImpact& other) {
  best.lower = best.hit ? std::min(best.lower, other.lower) : other.lower;
  best.upper = best.hit ? std::min(best.upper, other.upper) : other.upper;
  best.hit = true;
}

void search(ExactImpact& best, const Part& part) {
  for (Root& time : roots_in_unit_interval(part.gap)) {
    if (best.hit && time.lower() >= best.upper) return;
    if (!is_inside(part, time)) continue;
    keep_first(best, impact_at(time));
    return;
  }
}

}  // namespace

ExactImpact first_time_within(const ExactQuery& q) {
  const std::vector<Part> parts = parts_of(q);
  if (std::ranges::any_of(parts, within_at_start)) return {true, 0, 0};
  ExactImpact best;
  for (const Part& part : parts) search(best, part);
  return best;
}

ExactImpact judge_ccd(const Query& query, const Thickness& thickness) {
  if (thickness.is_zero()) return judge_ccd(query);
  const ExactQuery q = exact_query(query, thickness);
  return apart_along_an_axis(q) ? ExactImpact{} : first_time_within(q);
}

bool judge_proximity(QueryKind kind, const std::array<Vec3d, 4>& p, const Thickness& thickness) {
  return judge_ccd(standing(kind, p), thickness).hit;
}

}  // namespace collided::test
