#include "gpu/exact/exact.hpp"
#include "gpu/exact/features.hpp"

namespace collided {

ExactImpact exact_ccd_vertex_triangle(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], double thickness) {
  return exact::first_impact(exact::vertex_triangle_contact(exact::in_motion(start, end, thickness)));
}

ExactImpact exact_ccd_edge_edge(const Vec3<double> (&start)[4], const Vec3<double> (&end)[4], double thickness) {
  return exact::first_impact(exact::edge_edge_contact(exact::in_motion(start, end, thickness)));
}

}  // namespace collided
