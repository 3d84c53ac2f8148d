#pragma once
// Features that touch at the start, and part.
//
// The star of a vertex is the vertex and all that an edge joins to it. That of an edge is its triangles, and that of a
// triangle is the triangle. A direction n parts two stars S and T if n . (s - t) >= 0 for all s in S and t in T, at the
// start and at the end, and so between, for ways are straight. The features part if n . (s - t) > 0 at the end for all
// of their own vertices.
//
// Then no edge pierces a triangle later on. For let an edge and a triangle have a point in common at t > 0. If they had
// none at the start, a vertex and a triangle or two edges of theirs meet between, and such pairs are judged by
// themselves. If they had one, some such pair of theirs touches at the start. Its stars contain the edge and the
// triangle and lie on either side of a plane across n all along. So the two have points in common in that plane alone,
// and then some pair of theirs touches at t: but those that touched have left the plane, and the others never touch.
//
// n has to know the side: with a vertex, that something of its own star lies above it along n; with edges, that the
// stars do not lie in one plane across n. What else a triangle is joined to is no evidence: a coin in a pit, whose
// walls rise beside it, would leave it through the bottom. So flat on flat stands, for it has two sides.

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

/// `Stars` has kFirst, the number of the first feature's vertices; own(i, use) for each of the four vertices;
/// around(feature, use) for what else is in the star of a feature, 0 or 1; neighbours(i, use) for what an edge joins to
/// a vertex; kMostEdges, how many of these are looked at for directions. They call use(start, end).
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
    Bounds<N + W> stars[2][2];  // of either feature, at the start and at the end
    for (int i = 0; i < 4; ++i) stars_.own(i, adding<N>(n, stars[i < Stars::kFirst ? 0 : 1]));
    const Integer<N + W> corner = stars[0][0].least;  // of a vertex: where it is
    for (int f = 0; f < 2; ++f) stars_.around(f, adding<N>(n, stars[f]));
    const int above = side > 0 ? 0 : 1;
    const Bounds<N + W>(&upper)[2] = stars[above], (&lower)[2] = stars[1 - above];
    for (int at = 0; at < 2; ++at)
      if (is_less(upper[at].least, lower[at].greatest)) return false;
    if (kind == ContactKind::kEdgeEdge) return is_less(lower[0].least, upper[0].greatest);
    return side > 0 ? is_less(corner, stars[0][0].greatest) : is_less(stars[0][0].least, corner);
  }
  /// Adds where vertices are along n at the start and at the end.
  template <int N>
  COLLIDED_HD auto adding(const Vec3<Integer<N>>& n, Bounds<N + W> (&bounds)[2]) const {
    return [&](const Vec3<double>& x, const Vec3<double>& y) {
      bounds[0].add(wide_dot(n, unit_.template count<W>(x) - base_));
      bounds[1].add(wide_dot(n, unit_.template count<W>(y) - base_));
    };
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
  for (int i = 0; i < 4; ++i) stars.own(i, see), stars.neighbours(i, see);  // among them what is around the features
  if (unit.fits<1>()) return Parting<kind, 1, Stars>(unit, stars).look();
  if (unit.fits<2>()) return Parting<kind, 2, Stars>(unit, stars).look();
  return false;
}

}  // namespace collided::exact::fixed
