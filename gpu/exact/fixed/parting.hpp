#pragma once
// Decides whether features that touch at the start part.
//
// Each feature has a star. The star of a vertex is its one-ring: the vertex and all vertices that an edge joins to it.
// The star of an edge is the triangles that share it. The star of a triangle is the triangle. A direction n separates
// the stars S and T if n . (s - t) >= 0 for all vertices s of S and t of T. It has to do so at the start and at the
// end; ways are straight, so it does so in between. The features part if in addition n . (s - t) > 0 at the end for all
// of their own vertices.
//
// Claim: no edge pierces a triangle after the start. Proof: let an edge and a triangle have a common point at t > 0.
// - They have none at the start. Then two of their features touch for the first time at some t > 0. Pairs that do not
//   touch at the start are judged by themselves, and never touch.
// - They have one at the start. Then two of their features touch at the start, and these part along some n. Their stars
//   contain the edge and the triangle. A plane across n separates these all along, so all common points are in this
//   plane, and two of their features touch at t. Those that touched at the start have left the plane by then. The
//   others never touch.
//
// n must come from the right side. For a vertex, some vertex of its own star is above it along n. For two edges, the
// stars are not both in one plane across n. The neighbours of a triangle are no evidence: the walls of a pit rise
// beside its bottom, and with them as evidence a coin could leave the pit through the bottom. Flat features that lie on
// each other have no known side, so they do not part.

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

  /// Returns true if the features part along one of several directions. These are their common normal at the start,
  /// their differences at the end, the changes of the differences, and the normals of the triangles around them.
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
