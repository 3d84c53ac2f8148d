#pragma once
// Decides whether an edge u v and a triangle T at rest cross. The templates take integers of fixed size on any backend,
// and of any size on the host (exact/crossings.hpp).
//
// Five volumes decide: two of T's corners with an end of the edge, and three of the edge with a side of T. The features
// are apart if both ends have the same sign, or if two sides have different signs, none of them 0. Otherwise they meet:
// - Not both ends in T's plane: the edge passes the plane in one point. The sides' volumes are in proportion to the
//   weights of that point, and none of them has another sign than the others.
// - Both ends in it: all five volumes are 0, and cutting the edge down to its part in T decides. If T has no area, the
//   sides' volumes have the sum 0. Then two signs differ, or T is a segment in one plane with the edge.
// A crossing implies that they meet: the moved features share a point for all small e, so that the real ones share one
// in the limit.

#include "gpu/exact/fixed/orientation.hpp"

namespace collided {

/// The relation of an edge u v and a triangle a b c that share no vertex.
struct EdgeTriangleVerdict {
  /// True if, with ties broken by the vertices' ids, u and v are on different sides of the triangle's plane, and the
  /// line from u to v passes the triangle's three sides alike. Implies `meets`.
  bool crosses = false;
  bool touches = false;  ///< they meet, but a determinant that decides it is 0: `crosses` follows from the ids' order
  bool meets = false;    ///< the closed edge and the closed triangle have a common point; independent of ids
  bool from_front = false;  ///< if it crosses: the normal (b - a) x (c - a) points to the side of u, ties broken
  // The common point, if they meet. In one plane it is the middle of what they share. Errors are below 2^-49.
  double along = 0;        ///< position on the edge, from 0 at u to 1 at v
  double weights[2] = {};  ///< of b and c, at least 0; their sum is at most 1, and the weight of a is the rest
};

namespace exact::fixed {

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
  /// Removes the points with f < 0.
  COLLIDED_HD COLLIDED_CALLED void cut(const OnEdge<Int>& f) {
    const bool cuts_first = value(f, first_).is_negative(), cuts_last = value(f, last_).is_negative();
    if (cuts_first && cuts_last)
      is_empty_ = true;
    else if (cuts_first)  // f rises; it is 0 where u has the weight f(v) and v the weight -f(u)
      first_ = {f.at_v, -f.at_u};
    else if (cuts_last)
      last_ = {-f.at_v, f.at_u};
  }
  /// Removes the points with f != 0.
  COLLIDED_HD void cut_to_zero(const OnEdge<Int>& f) {
    cut(f);
    cut({-f.at_u, -f.at_v});
  }
  /// Returns the first point, by weights of u and v that are not negative and whose sum is not 0.
  COLLIDED_HD OnEdge<Int> first() const { return {first_.u, first_.v}; }
  /// Returns the middle's position on the edge, from 0 at u to 1 at v.
  COLLIDED_HD double middle() const { return 0.5 * (ratio(first_.v, first_.sum()) + ratio(last_.v, last_.sum())); }
  /// Returns f / total at the middle; they have one sign, and |f| <= |total| on this part.
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
  /// `points` holds u v a b c, `ids` their ids, all different. Both outlive this.
  COLLIDED_HD EdgeTriangle(const Vec3<Int>* points, const uint32_t (&ids)[5]) : p_(points), ids_(ids) {}

  COLLIDED_HD EdgeTriangleVerdict verdict() const {
    EdgeTriangleVerdict verdict;
    const Vec3<Area> normal = wide_cross(p_[kB] - p_[kA], p_[kC] - p_[kA]);
    const Volume at_u = wide_dot(p_[kU] - p_[kA], normal), at_v = wide_dot(p_[kV] - p_[kA], normal);
    if (at_u.sign() * at_v.sign() > 0) return verdict;
    const Volume sides[3] = {with_side(kB, kC), with_side(kC, kA), with_side(kA, kB)};
    const int s[3] = {sides[0].sign(), sides[1].sign(), sides[2].sign()};
    if (s[0] * s[1] < 0 || s[1] * s[2] < 0 || s[2] * s[0] < 0) return verdict;
    if (at_u.is_zero() && at_v.is_zero()) {
      EdgePart<Area> part;
      if (!find_common_part(normal, part, verdict)) return verdict;
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
  /// Returns a common point of an edge and a triangle that meet, exactly, by weights of u and v that are not negative
  /// and whose sum is not 0. For integers of any size.
  OnEdge<Int> common_point() const {
    const Vec3<Area> normal = wide_cross(p_[kB] - p_[kA], p_[kC] - p_[kA]);
    const Volume at_u = wide_dot(p_[kU] - p_[kA], normal), at_v = wide_dot(p_[kV] - p_[kA], normal);
    if (at_u.is_negative() || at_v.sign() > 0) return {at_v, -at_u};
    if (at_u.sign() > 0 || at_v.is_negative()) return {-at_v, at_u};
    EdgePart<Area> part;
    EdgeTriangleVerdict verdict;
    find_common_part(normal, part, verdict);
    return part.first();
  }

 private:
  using Area = decltype(Int{} * Int{});
  using Volume = decltype(Area{} * Int{});
  static constexpr int kU = 0, kV = 1, kA = 2, kB = 3, kC = 4;

  COLLIDED_HD Volume with_side(int from, int to) const { return volume(p_[kU], p_[kV], p_[from], p_[to]); }
  COLLIDED_HD int with_ties(int sign, int i, int j, int k, int l) const {
    return sign_with_ties(sign, {&p_[i], &p_[j], &p_[k], &p_[l]}, {ids_[i], ids_[j], ids_[k], ids_[l]});
  }
  COLLIDED_HD bool crosses_with_ties(int side_of_u, int at_v, const int (&s)[3]) const {
    if (with_ties(at_v, kA, kB, kC, kV) == side_of_u) return false;
    const int first = with_ties(s[0], kU, kV, kB, kC);
    return with_ties(s[1], kU, kV, kC, kA) == first && with_ties(s[2], kU, kV, kA, kB) == first;
  }
  /// Keeps the sum at most 1 in spite of rounding.
  COLLIDED_HD static void set_weights(EdgeTriangleVerdict& verdict, double b, double c) {
    verdict.weights[0] = b;
    verdict.weights[1] = min(c, 1 - b);
  }

  // The rest handles an edge in the plane of T.

  COLLIDED_HD COLLIDED_CALLED bool find_common_part(const Vec3<Area>& normal, EdgePart<Area>& part,
                                                    EdgeTriangleVerdict& verdict) const {
    return is_zero(normal) ? find_part_of_segment(part, verdict) : find_part_in_face(normal, part, verdict);
  }
  /// Works in the projection along an axis that leaves T an area.
  COLLIDED_HD bool find_part_in_face(const Vec3<Area>& normal, EdgePart<Area>& part,
                                     EdgeTriangleVerdict& verdict) const {
    const int axis = !normal.x.is_zero() ? 0 : !normal.y.is_zero() ? 1 : 2;
    const Area& area = component(normal, axis);
    const OnEdge<Area> f[3] = {area_with(kB, kC, axis), area_with(kC, kA, axis), area_with(kA, kB, axis)};
    for (int i = 0; i < 3; ++i) part.cut(area.is_negative() ? OnEdge<Area>{-f[i].at_u, -f[i].at_v} : f[i]);
    if (part.is_empty()) return false;
    verdict.along = part.middle();
    set_weights(verdict, part.middle_of(f[1], area), part.middle_of(f[2], area));
    return true;
  }
  /// Takes T for the segment p q from its least to its greatest corner, or for a point.
  COLLIDED_HD bool find_part_of_segment(EdgePart<Area>& part, EdgeTriangleVerdict& verdict) const {
    int least = kA, greatest = kA;
    for (int i = kB; i <= kC; ++i) {
      if (is_before(p_[i], p_[least])) least = i;
      if (is_before(p_[greatest], p_[i])) greatest = i;
    }
    const Vec3<Int>& p = p_[least];
    const Vec3<Int> pq = p_[greatest] - p, pu = p_[kU] - p, pv = p_[kV] - p, uv = pv - pu;
    // The direction of the line that contains p q and the common part, or from one point to the other.
    const Vec3<Int>& d = !is_zero(pq) ? pq : !is_zero(uv) ? uv : pu;
    const Vec3<Area> off_u = wide_cross(d, pu), off_v = wide_cross(d, pv);
    const OnEdge<Area> from_p{wide_dot(d, pu), wide_dot(d, pv)};
    const Area length = wide_dot(d, pq);
    const OnEdge<Area> to_q{length - from_p.at_u, length - from_p.at_v};
    part.cut_to_zero({off_u.x, off_v.x});
    part.cut_to_zero({off_u.y, off_v.y});
    part.cut_to_zero({off_u.z, off_v.z});
    part.cut(from_p);
    part.cut(to_q);
    if (part.is_empty()) return false;
    verdict.along = part.middle();
    const auto weight = [&](int corner) {
      return corner == greatest ? part.middle_of(from_p, length) : corner == least ? part.middle_of(to_q, length) : 0;
    };
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

/// Does the same as exact_edge_triangle() (exact/crossings.hpp), on any backend. Returns false, and leaves `verdict` as
/// it is, if the exponents of the coordinates are too far apart. Then the host has to decide.
COLLIDED_HD inline bool decide_edge_triangle(const Vec3<double> (&points)[5], const uint32_t (&ids)[5],
                                             EdgeTriangleVerdict& verdict) {
  return with_fixed_integers(points, [&](const auto* p) { verdict = EdgeTriangle(p, ids).verdict(); });
}

}  // namespace exact::fixed

}  // namespace collided
