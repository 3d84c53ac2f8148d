#pragma once
// Decides whether the ray from a vertex v in the direction of z crosses a triangle. The templates take integers of
// fixed size on any backend, and of any size on the host (exact/rays.hpp).
//
// The ray crosses triangle a b c if, seen from +z, v passes the sides ab, bc and ca alike, and if v is below the plane
// through a, b and c. Ties are broken as in orientation.hpp, where each vertex moves by the same powers of e. So all
// rays and crossings see one moved mesh, and the ray's crossings with a closed mesh add up to the winding number of the
// moved vertex. Seen from +z, the area of points p0 p1 p2 in the order of ids is linear in each coordinate, too:
//
//   number    derivative by     is
//    1,  2    0x     0y         p1.y - p2.y    p2.x - p1.x
//    8, 10    1x     1x 0y      p2.y - p0.y    -1

#include "gpu/exact/fixed/orientation.hpp"

namespace collided {

/// The relation of a triangle and the ray from a vertex in the direction of z.
struct RayVerdict {
  /// With ties broken: 1 if the ray leaves through the triangle's front, -1 if it enters through it, 0 if it does not
  /// cross. From the front the corners are seen counter-clockwise. The sum over a closed mesh is the winding number of
  /// the moved vertex, which is the real one unless the vertex is on the mesh.
  int crossing = 0;
  bool is_on = false;  ///< the vertex is on the closed triangle in real arithmetic; independent of ids
};

namespace exact::fixed {

/// Returns the area's sign, 1 or -1, with ties broken, for points of area 0 in the order of their ids.
template <class Int>
COLLIDED_HD int sign_of_flat_tie(const Vec3<Int>& p0, const Vec3<Int>& p1, const Vec3<Int>& p2) {
  const Int by_0x = p1.y - p2.y, by_0y = p2.x - p1.x, by_1x = p2.y - p0.y;
  if (!by_0x.is_zero()) return by_0x.sign();
  if (!by_0y.is_zero()) return by_0y.sign();
  return by_1x.is_zero() ? -1 : by_1x.sign();
}

/// Returns 1 if points a b c are counter-clockwise as seen from +z, -1 if they are clockwise, with ties broken.
/// `area_sign` is the real sign of that area; `ids` are the points' ids, all different.
template <class Int>
COLLIDED_HD COLLIDED_CALLED int flat_sign_with_ties(int area_sign, const Vec3<Int>* const (&points)[3],
                                                    const uint32_t (&ids)[3]) {
  if (area_sign != 0) return area_sign;
  int order[3];
  const int parity = sort_by_ids(ids, order);
  return parity * sign_of_flat_tie(*points[order[0]], *points[order[1]], *points[order[2]]);
}

/// Decides one query. `Int` has room for what differences.hpp says.
template <class Int>
class RayTriangle {
 public:
  /// `points` holds v a b c, `ids` their ids, all different. Both outlive this.
  COLLIDED_HD RayTriangle(const Vec3<Int>* points, const uint32_t (&ids)[4]) : p_(points), ids_(ids) {}

  COLLIDED_HD RayVerdict verdict() const {
    const int s[3] = {area_with(kB, kC), area_with(kC, kA), area_with(kA, kB)};
    if (s[0] * s[1] < 0 || s[1] * s[2] < 0 || s[2] * s[0] < 0) return {};
    const int height = volume(p_[kA], p_[kB], p_[kC], p_[kV]).sign();
    const bool is_seen_in_line = s[0] == 0 && s[1] == 0 && s[2] == 0;  // the triangle is upright or has no area
    RayVerdict verdict;
    verdict.is_on = height == 0 && (!is_seen_in_line || is_on_upright());
    const int side = with_ties(s[0], kB, kC);
    if (with_ties(s[1], kC, kA) != side || with_ties(s[2], kA, kB) != side) return verdict;
    const bool is_below =
        sign_with_ties(height, {&p_[kA], &p_[kB], &p_[kC], &p_[kV]}, {ids_[kA], ids_[kB], ids_[kC], ids_[kV]}) != side;
    verdict.crossing = is_below ? side : 0;
    return verdict;
  }

 private:
  static constexpr int kV = 0, kA = 1, kB = 2, kC = 3;

  /// Returns the sign of the area of v and two corners as seen from +z.
  COLLIDED_HD int area_with(int from, int to) const {
    const Int from_x = p_[from].x - p_[kV].x, from_y = p_[from].y - p_[kV].y;
    const Int to_x = p_[to].x - p_[kV].x, to_y = p_[to].y - p_[kV].y;
    return (from_x * to_y - from_y * to_x).sign();
  }
  COLLIDED_HD int with_ties(int sign, int from, int to) const {
    return flat_sign_with_ties(sign, {&p_[kV], &p_[from], &p_[to]}, {ids_[kV], ids_[from], ids_[to]});
  }
  /// Decides for v in one upright plane with the triangle. It is on a side or, along x or y, passes the sides alike.
  COLLIDED_HD COLLIDED_CALLED bool is_on_upright() const {
    const Vec3<Int> a = p_[kA] - p_[kV], b = p_[kB] - p_[kV], c = p_[kC] - p_[kV];
    const auto bc = wide_cross(b, c), ca = wide_cross(c, a), ab = wide_cross(a, b);
    const auto are_alike = [](int first, int second, int third) {
      return first != 0 && first == second && first == third;
    };
    return is_between(bc, b, c) || is_between(ca, c, a) || is_between(ab, a, b) ||
           are_alike(bc.x.sign(), ca.x.sign(), ab.x.sign()) || are_alike(bc.y.sign(), ca.y.sign(), ab.y.sign());
  }
  template <class Area>
  COLLIDED_HD static bool is_between(const Vec3<Area>& product, const Vec3<Int>& from, const Vec3<Int>& to) {
    return is_zero(product) && wide_dot(from, to).sign() <= 0;
  }

  const Vec3<Int>* p_;
  const uint32_t (&ids_)[4];
};

/// Does the same as exact_ray() (exact/rays.hpp), on any backend. Returns false, and leaves `verdict` as it is, if the
/// exponents of the coordinates are too far apart. Then the host has to decide.
COLLIDED_HD inline bool decide_ray(const Vec3<double> (&points)[4], const uint32_t (&ids)[4], RayVerdict& verdict) {
  return with_fixed_integers(points, [&](const auto* p) { verdict = RayTriangle(p, ids).verdict(); });
}

}  // namespace exact::fixed

}  // namespace collided
