#include "gpu/exact/decision.hpp"

namespace collided {

ExactAnswer decide_exactly(const ExactQuestion& question, const ExactPoints& p) {
  const Vec3<double> start[4] = {p[0], p[1], p[2], p[3]}, end[4] = {p[4], p[5], p[6], p[7]};
  const auto near = question.vertex_triangle ? exact_proximity_vertex_triangle : exact_proximity_edge_edge;
  if (!question.continuous) return {near(end, question.thickness), 0, false};
  const ExactImpact impact = question.vertex_triangle ? exact_ccd_vertex_triangle(start, end, question.thickness)
                                                      : exact_ccd_edge_edge(start, end, question.thickness);
  // A time below 2^-60 is rounded to 0 too.
  return {impact.hit, impact.toi, impact.hit && impact.toi == 0 && near(start, question.thickness)};
}

ExactAnswer decide_triangles_exactly(const ExactTriangles& p) {
  return {exact_triangles_intersect({p[0], p[1], p[2]}, {p[3], p[4], p[5]}), 0, false};
}

}  // namespace collided
