#include "gpu/exact/exact.hpp"
#include "gpu/exact/features.hpp"

namespace collided {

bool exact_proximity_vertex_triangle(const Vec3<double> (&p)[4], double thickness) {
  return exact::holds_at_start(exact::vertex_triangle_contact(exact::at_rest(p, thickness)));
}

bool exact_proximity_edge_edge(const Vec3<double> (&p)[4], double thickness) {
  return exact::holds_at_start(exact::edge_edge_contact(exact::at_rest(p, thickness)));
}

}  // namespace collided
