// If triangles share a point, an extreme point of their intersection is on an edge of one of them: that edge passes
// through the inside of the other triangle, or ends on it, or meets an edge of it.

#include "tests/support/judge/exact_geometry.hpp"

namespace collided::test {
namespace {

using Triangle = std::array<Vec3d, 3>;

// Which side of the plane a b c is p on; 0: coplanar.
int side(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const ExactQuery q = exact_query(standing(QueryKind::kVertexTriangle, {p, a, b, c}), 0);
  return coplanarity(q, normal_of(q)).sign_at_zero();
}

// The ends are strictly on two sides of the plane, and the edge passes no side of the triangle on its outside.
bool pierces(const Vec3d& p, const Vec3d& q, const Triangle& t) {
  if (side(p, t[0], t[1], t[2]) * side(q, t[0], t[1], t[2]) >= 0) return false;
  const int first = side(t[0], t[1], p, q), second = side(t[1], t[2], p, q), third = side(t[2], t[0], p, q);
  return (first >= 0 && second >= 0 && third >= 0) || (first <= 0 && second <= 0 && third <= 0);
}

// Whether a corner of `a` is on `b` or an edge of `a` pierces it, not counting edges that meet edges.
bool reaches(const Triangle& a, const Triangle& b) {
  for (int i = 0; i < 3; ++i) {
    if (judge_proximity(QueryKind::kVertexTriangle, {a[i], b[0], b[1], b[2]}, 0)) return true;
    if (pierces(a[i], a[(i + 1) % 3], b)) return true;
  }
  return false;
}

bool edges_meet(const Triangle& a, const Triangle& b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (judge_proximity(QueryKind::kEdgeEdge, {a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]}, 0)) return true;
  return false;
}

bool boxes_meet(const Triangle& a, const Triangle& b) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto below = [axis](const Triangle& first, const Triangle& second) {
      for (const Vec3d& p : first)
        for (const Vec3d& q : second)
          if (!(p[axis] < q[axis])) return false;
      return true;
    };
    if (below(a, b) || below(b, a)) return false;
  }
  return true;
}

}  // namespace

bool judge_triangles(const Triangle& a, const Triangle& b) {
  return boxes_meet(a, b) && (reaches(a, b) || reaches(b, a) || edges_meet(a, b));
}

// A side is a triangle whose last two corners are one.
bool judge_neighbours(const Triangle& a, const Triangle& b) {
  return judge_triangles({a[1], a[2], a[2]}, b) || judge_triangles({b[1], b[2], b[2]}, a);
}

}  // namespace collided::test
