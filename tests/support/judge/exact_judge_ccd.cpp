// Contact: the times at which the four points are coplanar are roots of a cubic; at each, signs say whether the
// features meet. Where they are coplanar all the time, exact_judge_distance.cpp decides.

#include "tests/support/judge/exact_distance.hpp"
#include "tests/support/judge/exact_geometry.hpp"

namespace collided::test {
namespace {

bool on_edge_at(Root& time, const ExactQuery& q, const VertexEdge& pair) {
  const PolynomialVector from = q.x[pair.from] - q.x[pair.vertex], to = q.x[pair.to] - q.x[pair.vertex];
  for (const Polynomial& component : cross(from, to))
    if (time.sign_of(component) != 0) return false;
  return time.sign_of(dot(from, to)) <= 0;
}

// The features have no common normal at this time: a triangle is its edges, and edges are parallel.
bool touch_without_normal(Root& time, const ExactQuery& q) {
  for (const VertexEdge& pair : vertex_edges(q.kind))
    if (on_edge_at(time, q, pair)) return true;
  return false;
}

// Whether coplanar features meet.
bool touch_at(Root& time, const ExactQuery& q, const Interior& interior) {
  bool has_normal = false;
  for (const Polynomial& condition : interior.inside) {
    const int sign = time.sign_of(condition);
    if (sign < 0) return false;
    has_normal = has_normal || sign > 0;
  }
  return has_normal || touch_without_normal(time, q);
}

bool never_coplanar(const Polynomial& f) {
  return sign_changes(f) == 0 && f.sign_at_zero() != 0 && f.sign_at_one() != 0;
}

}  // namespace

ExactImpact impact_at(Root& time) {
  time.refine(60);
  return {true, time.lower(), time.upper()};
}

ExactImpact judge_ccd(const Query& query) {
  const ExactQuery q = exact_query(query, 0);
  if (apart_along_an_axis(query)) return {};
  const Polynomial f = coplanarity(q, normal_of(q));
  if (f.is_zero()) return first_time_within(q);
  if (never_coplanar(f)) return {};
  const Interior interior = interior_of(q);
  for (Root& time : roots_in_unit_interval(f))
    if (touch_at(time, q, interior)) return impact_at(time);
  return {};
}

}  // namespace collided::test
