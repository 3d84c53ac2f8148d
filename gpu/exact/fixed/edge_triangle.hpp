#pragma once
// The decision of crossings.hpp, for integers of fixed size on any backend and, as templates, for those of any size.
//
// Five volumes decide it: those of T's corners with u and with v, and those of u v with each side of T. Where they are
// not 0, signs that differ (of the sides) or agree (of the ends) show that the two are apart. Else they meet:
// - if a crossing depends on ties, the moved edge and triangle share a point for all small e, so that u v and T share
//   one in the limit: `crosses` implies `meets`;
// - if u and v are not both in T's plane, u v passes that plane in one point, whose weights are in proportion to the
//   sides' volumes, none of them of another sign;
// - if both are, all five volumes are 0, and the edge is cut down to its part in T. (For a T without area the sides'
//   volumes have the sum 0, so that they differ, or all are 0 and T is a segment in one plane with the edge.)

#include "gpu/exact/crossings.hpp"
#include "gpu/exact/fixed/orientation.hpp"

namespace collided::exact::fixed {

/// A function on an edge that changes linearly, by its values at the edge's ends.
template <class Int>
struct OnEdge {
  Int at_u, at_v;
};

/// The part of an edge on which certain functions are >= 0.
template <class Int>
class EdgePart {
 public:
  COLLIDED_HD bool is_empty() const { return is_empty_; }
  /// Leaves out where f < 0.
  COLLIDED_HD COLLIDED_CALLED void cut(const OnEdge<Int>& f) {
    const bool cuts_first = value(f, first_).is_negative(), cuts_last = value(f, last_).is_negative();
    if (cuts_first && cuts_last)
      is_empty_ = true;
    else if (cuts_first)  // f rises; it is 0 where u has the weight f(v) and v the weight -f(u)
      first_ = {f.at_v, -f.at_u};
    else if (cuts_last)
      last_ = {-f.at_v, f.at_u};
  }
  /// Leaves what has f = 0.
  COLLIDED_HD void cut_to_zero(const OnEdge<Int>& f) {
    cut(f);
    cut({-f.at_u, -f.at_v});
  }
  /// The middle's position on the edge, 0 at u to 1 at v.
  COLLIDED_HD double middle() const { return 0.5 * (ratio(first_.v, first_.sum()) + ratio(last_.v, last_.sum())); }
  /// f / total at the middle, for 0 <= f <= total on this part.
  COLLIDED_HD COLLIDED_CALLED double middle_of(const OnEdge<Int>& f, const Int& total) const {
    return 0.5 * (ratio(value(f, first_), first_.sum() * total) + ratio(value(f, last_), last_.sum() * total));
  }

 private:
  /// A point of the edge, by weights of its ends that are not negative and whose sum is not 0.
  struct Weights {
    Int u, v;
    COLLIDED_HD Int sum() const { return u + v; }
  };
  COLLIDED_HD static auto value(const OnEdge<Int>& f, const Weights& at) { return f.at_u * at.u + f.at_v * at.v; }

  Weights first_{Int{1}, Int{}}, last_{Int{}, Int{1}};
  bool is_empty_ = false;
};

/// Decides one query. `Int` has room for what differences.hpp says.
template <class Int>
class EdgeTriangle {
 public:
  /// `points` are u v a b c, `ids` theirs, all different; both outlive this.
  COLLIDED_HD EdgeTriangle(const Vec3<Int>* points, const uint32_t (&ids)[5]) : p_(points), ids_(ids) {}

  COLLIDED_HD EdgeTriangleVerdict verdict() const {
    EdgeTriangleVerdict verdict;
    const Volume at_u = volume_of(kA, kB, kC, kU), at_v = volume_of(kA, kB, kC, kV);
    if (at_u.sign() * at_v.sign() > 0) return verdict;
    const Volume sides[3] = {volume_of(kU, kV, kB, kC), volume_of(kU, kV, kC, kA), volume_of(kU, kV, kA, kB)};
    const int s[3] = {sides[0].sign(), sides[1].sign(), sides[2].sign()};
    if (s[0] * s[1] < 0 || s[1] * s[2] < 0 || s[2] * s[0] < 0) return verdict;
    if (at_u.is_zero() && at_v.is_zero()) {
      if (!find_common_part(verdict)) return verdict;
    } else {
      const Volume all = at_u - at_v;  // but for the sign, the sum of the sides' volumes, too
      verdict.along = ratio(at_u, all);
      set_weights(verdict, ratio(sides[1], all), ratio(sides[2], all));
    }
    verdict.meets = true;
    verdict.touches = at_u.sign() * at_v.sign() * s[0] * s[1] * s[2] == 0;
    const int side_of_u = with_ties(at_u.sign(), kA, kB, kC, kU);
    verdict.crosses = !verdict.touches || crosses_with_ties(side_of_u, at_v.sign(), s);
    verdict.from_front = verdict.crosses && side_of_u > 0;
    return verdict;
  }

 private:
  using Area = decltype(Int{} * Int{});
  using Volume = decltype(Area{} * Int{});
  static constexpr int kU = 0, kV = 1, kA = 2, kB = 3, kC = 4;

  COLLIDED_HD Volume volume_of(int i, int j, int k, int l) const { return volume(p_[i], p_[j], p_[k], p_[l]); }
  COLLIDED_HD int with_ties(int sign, int i, int j, int k, int l) const {
    return sign_with_ties(sign, {&p_[i], &p_[j], &p_[k], &p_[l]}, {ids_[i], ids_[j], ids_[k], ids_[l]});
  }
  COLLIDED_HD bool crosses_with_ties(int side_of_u, int at_v, const int (&s)[3]) const {
    if (with_ties(at_v, kA, kB, kC, kV) == side_of_u) return false;
    const int first = with_ties(s[0], kU, kV, kB, kC);
    return with_ties(s[1], kU, kV, kC, kA) == first && with_ties(s[2], kU, kV, kA, kB) == first;
  }
  /// The sum stays at most 1 in spite of rounding.
  COLLIDED_HD static void set_weights(EdgeTriangleVerdict& verdict, double b, double c) {
    verdict.weights[0] = b;
    verdict.weights[1] = min(c, 1 - b);
  }

  // The rest is for an edge in the plane of T.

  COLLIDED_HD COLLIDED_CALLED bool find_common_part(EdgeTriangleVerdict& verdict) const {
    const Vec3<Area> normal = wide_cross(p_[kB] - p_[kA], p_[kC] - p_[kA]);
    return is_zero(normal) ? find_part_of_segment(verdict) : find_part_in_face(normal, verdict);
  }
  /// In the projection along an axis in which T keeps an area.
  COLLIDED_HD bool find_part_in_face(const Vec3<Area>& normal, EdgeTriangleVerdict& verdict) const {
    const int axis = !normal.x.is_zero() ? 0 : !normal.y.is_zero() ? 1 : 2;
    const Area& area = component(normal, axis);
    const OnEdge<Area> f[3] = {area_with(kB, kC, axis), area_with(kC, kA, axis), area_with(kA, kB, axis)};
    EdgePart<Area> part;
    for (int i = 0; i < 3; ++i) part.cut(area.is_negative() ? OnEdge<Area>{-f[i].at_u, -f[i].at_v} : f[i]);
    if (part.is_empty()) return false;
    verdict.along = part.middle();
    set_weights(verdict, part.middle_of(f[1], area), part.middle_of(f[2], area));
    return true;
  }
  /// T is the segment from its least to its greatest corner, p q, or a point.
  COLLIDED_HD bool find_part_of_segment(EdgeTriangleVerdict& verdict) const {
    int least = kA, greatest = kA;
    for (int i = kB; i <= kC; ++i) {
      if (is_before(p_[i], p_[least])) least = i;
      if (is_before(p_[greatest], p_[i])) greatest = i;
    }
    const Vec3<Int>& p = p_[least];
    const Vec3<Int> pq = p_[greatest] - p, pu = p_[kU] - p, pv = p_[kV] - p, uv = pv - pu;
    // A direction of the line that holds p q and the common part; if all are points, one that parts them.
    const Vec3<Int>& d = !is_zero(pq) ? pq : !is_zero(uv) ? uv : pu;
    const Vec3<Area> off_u = wide_cross(d, pu), off_v = wide_cross(d, pv);
    const OnEdge<Area> from_p{wide_dot(d, pu), wide_dot(d, pv)};
    const Area length = wide_dot(d, pq);
    EdgePart<Area> part;
    part.cut_to_zero({off_u.x, off_v.x});
    part.cut_to_zero({off_u.y, off_v.y});
    part.cut_to_zero({off_u.z, off_v.z});
    part.cut(from_p);
    part.cut({length - from_p.at_u, length - from_p.at_v});
    if (part.is_empty()) return false;
    verdict.along = part.middle();
    const double of_q = length.is_zero() ? 0 : part.middle_of(from_p, length);
    const auto weight = [&](int corner) { return corner == greatest ? of_q : corner == least ? 1 - of_q : 0; };
    set_weights(verdict, weight(kB), weight(kC));
    return true;
  }
  COLLIDED_HD OnEdge<Area> area_with(int from, int to, int axis) const {
    const Vec3<Int> side = p_[to] - p_[from];
    return {component(wide_cross(side, p_[kU] - p_[from]), axis), component(wide_cross(side, p_[kV] - p_[from]), axis)};
  }
  COLLIDED_HD static const Area& component(const Vec3<Area>& v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
  }
  COLLIDED_HD static bool is_before(const Vec3<Int>& a, const Vec3<Int>& b) {
    const Vec3<Int> d = a - b;
    return (!d.x.is_zero() ? d.x : !d.y.is_zero() ? d.y : d.z).is_negative();
  }

  const Vec3<Int>* p_;
  const uint32_t (&ids_)[5];
};

/// exact_edge_triangle() on any backend. Returns false, and leaves `verdict` as it is, if the exponents of the
/// coordinates are too far apart: then the host decides.
COLLIDED_HD inline bool decide_edge_triangle(const Vec3<double> (&points)[5], const uint32_t (&ids)[5],
                                             EdgeTriangleVerdict& verdict) {
  return with_fixed_integers(points, [&](const auto* p) { verdict = EdgeTriangle(p, ids).verdict(); });
}

}  // namespace collided::exact::fixed
