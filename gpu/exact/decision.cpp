#include "gpu/exact/decision.hpp"

namespace collided {

ExactAnswer decide_exactly(const ExactQuestion& question, const ExactPoints& p) {
  const Vec3<double> start[4] = {p[0], p[1], p[2], p[3]}, end[4] = {p[4], p[5], p[6], p[7]};
  if (!question.continuous) return {exact_proximity(question.kind, end, question.limit), 0, false};
  const ExactImpact impact = exact_ccd(question.kind, start, end, question.limit);
  return {impact.hit, impact.toi, impact.initial};
}

ExactAnswer decide_triangles_exactly(const ExactTriangles& p, bool has_common_corner) {
  const auto meet = has_common_corner ? exact_triangles_meet_beyond_corner : exact_triangles_intersect;
  return {meet({p[0], p[1], p[2]}, {p[3], p[4], p[5]}), 0, false};
}

}  // namespace collided
