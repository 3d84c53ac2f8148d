#pragma once
// Features that touch at the start, and part.
//
// The star of a feature is its vertices and all that an edge joins to them. A direction n parts two stars S and T if
// n . (s - t) >= 0 for all s in S and t in T, at the start and at the end, and so between, for ways are straight. The
// features part if n . (s - t) > 0 at the end for all of their own vertices.
//
// Then no edge pierces a triangle later on. For let an edge and a triangle have a point in common at t > 0. Without one
// at the start, a vertex and a triangle or two edges of theirs would first meet between; such pairs are judged by
// themselves. With one, such a pair touches at the start. It is in the stars, which lie on either side of a plane across
// n all along, so that the two can meet in that plane alone, which the features of that pair have left.
//
// The direction has to know the side: n . (s - t) > 0 at the start for some of the stars. Sheets that lie on each other
// have two sides, and no direction that tells them apart.

#include "gpu/exact/fixed/differences.hpp"

namespace collided::exact::fixed {

template <int N>
COLLIDED_HD bool is_less(const Integer<N>& a, const Integer<N>& b) {
  return (a - b).is_negative();
}

/// The least and the greatest of numbers.
template <int N>
struct Bounds {
  Integer<N> least, greatest;
  bool is_empty = true;

  COLLIDED_HD void add(const Integer<N>& x) {
    if (is_empty || is_less(x, least)) least = x;
    if (is_empty || is_less(greatest, x)) greatest = x;
    is_empty = false;
  }
};

/// `Stars` has kFirst, the number of the first feature's vertices, own(i, use) for each of the four vertices, and
/// neighbours(i, use) for all that an edge joins to it: use(start, end).
template <ContactKind kind, int W, class Stars>
class Parting {
 public:
  COLLIDED_HD Parting(const Unit& unit, const Stars& stars) : unit_(unit), stars_(stars) {
    stars.own(0, [&](const Vec3<double>& start, const Vec3<double>&) { base_ = unit.count<W>(start); });
    Vec3<double> start[4], end[4];
    for (int i = 0; i < 4; ++i)
      stars.own(i, [&](const Vec3<double>& x, const Vec3<double>& y) { start[i] = x, end[i] = y; });
    features_ = Differences<kind, W>(unit, start, end);
  }

  /// Whether one of these directions shows that the features part: their common normal at the start, their differences
  /// at the end and the changes of these, and the normals of the triangles around them.
  COLLIDED_HD bool look() const {
    if (parts_along(normal())) return true;
    for (const Moving<W>& d : features_.d)
      if (parts_along(d.p[1]) || parts_along(d.p[1] - d.p[0])) return true;
    for (int i = 0; i < 4; ++i)
      if (any_normal_around(i)) return true;
    return false;
  }

 private:
  COLLIDED_HD Vec3<Integer<2 * W>> normal() const {
    Vec3<Integer<2 * W>> sides[Sides<kind>::kCount];
    for (int i = 0; i < Sides<kind>::kCount; ++i)
      sides[i] = wide_cross(features_.d[Sides<kind>::at(i).p].p[0], features_.d[Sides<kind>::at(i).q].p[0]);
    return normal_of<kind>(sides);
  }
  /// The normals of all pairs of edges at a vertex.
  COLLIDED_HD COLLIDED_CALLED bool any_normal_around(int i) const {
    Vec3<Integer<W>> edges[Stars::kMostEdges];
    int count = 0;
    Vec3<Integer<W>> corner;
    stars_.own(i, [&](const Vec3<double>& x, const Vec3<double>&) { corner = unit_.template count<W>(x); });
    stars_.neighbours(i, [&](const Vec3<double>& x, const Vec3<double>&) {
      if (count < Stars::kMostEdges) edges[count++] = unit_.template count<W>(x) - corner;
    });
    for (int a = 0; a < count; ++a)
      for (int b = 0; b < a; ++b)
        if (parts_along(wide_cross(edges[a], edges[b]))) return true;
    return false;
  }
  /// `n`: or its opposite.
  template <int N>
  COLLIDED_HD COLLIDED_CALLED bool parts_along(const Vec3<Integer<N>>& n) const {
    const int side = wide_dot(features_.d[0].p[1], n).sign();
    if (side == 0) return false;
    for (const Moving<W>& d : features_.d)
      if (wide_dot(d.p[1], n).sign() != side || wide_dot(d.p[0], n).sign() == -side) return false;
    Bounds<N + W> first[2], second[2];  // at the start and at the end
    for (int i = 0; i < 4; ++i) {
      Bounds<N + W>(&bounds)[2] = i < Stars::kFirst ? first : second;
      const auto add = [&](const Vec3<double>& x, const Vec3<double>& y) {
        bounds[0].add(wide_dot(n, unit_.template count<W>(x) - base_));
        bounds[1].add(wide_dot(n, unit_.template count<W>(y) - base_));
      };
      stars_.own(i, add);
      stars_.neighbours(i, add);
    }
    const Bounds<N + W>(&upper)[2] = side > 0 ? first : second, (&lower)[2] = side > 0 ? second : first;
    for (int at = 0; at < 2; ++at)
      if (is_less(upper[at].least, lower[at].greatest)) return false;
    return is_less(lower[0].least, upper[0].greatest);
  }

  const Unit& unit_;
  const Stars& stars_;
  Vec3<Integer<W>> base_;
  Differences<kind, W> features_;
};

/// True if two features part, for certain. False says nothing.
template <ContactKind kind, class Stars>
COLLIDED_HD COLLIDED_CALLED bool part(const Stars& stars) {
  Unit unit;
  const auto see = [&](const Vec3<double>& x, const Vec3<double>& y) {
    unit.see(x.x), unit.see(x.y), unit.see(x.z), unit.see(y.x), unit.see(y.y), unit.see(y.z);
  };
  for (int i = 0; i < 4; ++i) stars.own(i, see), stars.neighbours(i, see);
  if (unit.fits<1>()) return Parting<kind, 1, Stars>(unit, stars).look();
  if (unit.fits<2>()) return Parting<kind, 2, Stars>(unit, stars).look();
  return false;
}

}  // namespace collided::exact::fixed
