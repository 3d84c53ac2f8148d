#include <algorithm>

#include "gpu/exact/crossings.hpp"
#include "gpu/exact/exact.hpp"
#include "gpu/exact/integers.hpp"

namespace collided {
namespace {

using Point = Vec3<double>;

/// Sign of the volume of a, b, c, d.
int orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  int sign = 0;
  exact::with_integers({a, b, c, d},
                       [&](const auto* p) { sign = exact::fixed::volume(p[0], p[1], p[2], p[3]).sign(); });
  return sign;
}

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

bool point_in_triangle(const Point& p, const Point (&t)[3]) {
  return exact_proximity(ContactKind::kVertexTriangle, {p, t[0], t[1], t[2]}, 0);
}

bool crosses_outline(const Point& p, const Point& q, const Point (&t)[3]) {
  for (int i = 0; i < 3; ++i)
    if (exact_proximity(ContactKind::kEdgeEdge, {p, q, t[i], t[(i + 1) % 3]}, 0)) return true;
  return false;
}

/// Edge p q, its ends on the sides `at_p` and `at_q` (signs) of the triangle's plane: it pierces the plane, or ends in
/// it, or lies in it. All points are in the plane of a triangle without area, which is its outline.
bool edge_meets(const Point& p, int at_p, const Point& q, int at_q, const Point (&t)[3]) {
  if (at_p * at_q < 0) return line_pierces(p, q, t);
  return (at_p == 0 && point_in_triangle(p, t)) || (at_q == 0 && point_in_triangle(q, t)) ||
         (at_p == 0 && at_q == 0 && crosses_outline(p, q, t));
}

/// A triangle's corners and on which sides of another's plane they are.
struct Seen {
  const Point (&p)[3];
  int sign[3];

  Seen(const Point (&corners)[3], const Point (&from)[3]) : p(corners) {
    for (int i = 0; i < 3; ++i) sign[i] = orientation(from[0], from[1], from[2], p[i]);
  }
  bool on_one_side() const { return sign[0] != 0 && sign[0] == sign[1] && sign[1] == sign[2]; }
};

bool some_edge_meets(const Seen& seen, const Point (&t)[3]) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (edge_meets(seen.p[i], seen.sign[i], seen.p[j], seen.sign[j], t)) return true;
  }
  return false;
}

/// The side from the second corner to the third.
bool last_side_meets(const Point (&a)[3], const Point (&b)[3]) {
  return exact_edge_triangle({a[1], a[2], b[0], b[1], b[2]}, {0, 1, 2, 3, 4}).meets;
}

}  // namespace

// Where triangles meet, an edge of one meets the other: outside a common plane their intersection is a segment whose
// ends lie on edges; in a common plane their outlines cross or one lies in the other; without area, a triangle is its
// edges.
bool exact_triangles_intersect(const Vec3<double> (&a)[3], const Vec3<double> (&b)[3]) {
  const Seen a_from_b(a, b);
  if (a_from_b.on_one_side()) return false;
  const Seen b_from_a(b, a);
  return !b_from_a.on_one_side() && (some_edge_meets(a_from_b, b) || some_edge_meets(b_from_a, a));
}

bool exact_triangles_meet_beyond_corner(const Vec3<double> (&a)[3], const Vec3<double> (&b)[3]) {
  return last_side_meets(a, b) || last_side_meets(b, a);
}

}  // namespace collided
