#include <algorithm>

#include "gpu/exact/exact.hpp"
#include "gpu/exact/integers.hpp"

namespace collided {
namespace {

using Point = Vec3<double>;

/// Sign of the volume of a, b, c, d.
int orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  const exact::ExactQuery query = exact::at_rest({a, b, c, d}, 0);
  const auto& [A, B, C, D] = query.points;
  return sgn(triple(B - A, C - A, D - A).c.front());
}

/// Where the corners of a triangle lie: the signs of their orientation to another triangle.
struct Sides {
  int sign[3];

  Sides(const Point (&t)[3], const Point (&corners)[3]) {
    for (int i = 0; i < 3; ++i) sign[i] = orientation(t[0], t[1], t[2], corners[i]);
  }
  bool all(int s) const { return sign[0] == s && sign[1] == s && sign[2] == s; }
};

/// The line through p and q, whose ends are on different sides of the triangle's plane, meets the triangle.
bool line_pierces(const Point& p, const Point& q, const Point (&t)[3]) {
  int least = 1, greatest = -1;
  for (int i = 0; i < 3; ++i) {
    const int s = orientation(p, q, t[i], t[(i + 1) % 3]);
    least = std::min(least, s);
    greatest = std::max(greatest, s);
  }
  return least >= 0 || greatest <= 0;
}

/// An edge of `corners` with its ends strictly on different sides of the plane of t meets t.
bool some_edge_pierces(const Point (&corners)[3], const Sides& sides, const Point (&t)[3]) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (sides.sign[i] * sides.sign[j] < 0 && line_pierces(corners[i], corners[j], t)) return true;
  }
  return false;
}

/// A corner in the plane of t lies in t.
bool some_corner_inside(const Point (&corners)[3], const Sides& sides, const Point (&t)[3]) {
  for (int i = 0; i < 3; ++i)
    if (sides.sign[i] == 0 && exact_proximity_vertex_triangle({corners[i], t[0], t[1], t[2]}, 0)) return true;
  return false;
}

bool some_edges_meet(const Point (&a)[3], const Point (&b)[3]) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (exact_proximity_edge_edge({a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]}, 0)) return true;
  return false;
}

}  // namespace

// Where triangles meet, an edge of one meets the other: outside a common plane their intersection is a segment whose
// ends lie on edges; in a common plane their outlines cross or one lies in the other; without area, a triangle is its
// edges. An edge that meets a triangle pierces it with its ends on different sides, or has an end in it, or lies in its
// plane and crosses an edge of it.
bool exact_triangles_intersect(const Vec3<double> (&a)[3], const Vec3<double> (&b)[3]) {
  const Sides of_b(a, b), of_a(b, a);
  if (of_b.all(1) || of_b.all(-1) || of_a.all(1) || of_a.all(-1)) return false;
  return some_edge_pierces(b, of_b, a) || some_edge_pierces(a, of_a, b) || some_corner_inside(b, of_b, a) ||
         some_corner_inside(a, of_a, b) || some_edges_meet(a, b);
}

}  // namespace collided
