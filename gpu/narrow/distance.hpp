#pragma once
// Closest points of a vertex and a triangle, and of two edges. Degenerate features need no special care:
// every division is guarded, and the boundary features are always among the candidates. Real is a number, or four of
// them side by side (base/four.hpp).

#include "gpu/base/choose.hpp"
#include "gpu/base/vec3.hpp"

namespace collided {

/// Squared distance and the two weights that place the closest points: those of the triangle's second and third
/// corner, or the positions along the two edges.
template <class Real>
struct Closest {
  Real squared;
  Real w0, w1;
};

template <class Real>
COLLIDED_HD void keep_if(const Mask<Real>& kept, Closest<Real>& best, const Closest<Real>& other) {
  best = {select(kept, other.squared, best.squared), select(kept, other.w0, best.w0), select(kept, other.w1, best.w1)};
}
template <class Real>
COLLIDED_HD void keep_closer(Closest<Real>& best, const Closest<Real>& other) {
  keep_if<Real>(other.squared < best.squared, best, other);
}

template <class Real>
COLLIDED_HD Real clamp01(Real t) {
  return min(max(t, Real(0)), Real(1));
}

/// Position along the edge a + t d of the point closest to p, t in [0, 1].
template <class Real>
COLLIDED_HD Real closest_on_edge(const Vec3<Real>& p, const Vec3<Real>& a, const Vec3<Real>& d) {
  const Real length2 = dot(d, d);
  return replace_where(length2 > 0, Real(0), [&] { return clamp01(dot(p - a, d) / length2); });
}

template <class Real>
COLLIDED_HD Real squared_length(const Vec3<Real>& v) {
  return dot(v, v);
}

/// Where two points are: on a triangle or on two edges, as in Closest.
template <class Real>
struct Weights {
  Real w0, w1;
  Mask<Real> inside;  ///< not on the border of the triangle, nor at an end of an edge
};

/// Vertex p against the border of triangle a b c.
template <class Real>
COLLIDED_HD Closest<Real> closest_on_border(const Vec3<Real>& p, const Vec3<Real>& a, const Vec3<Real>& b,
                                            const Vec3<Real>& c) {
  const Vec3<Real> ab = b - a, ac = c - a, ap = p - a;
  const Real t_ab = closest_on_edge(p, a, ab), t_ac = closest_on_edge(p, a, ac), t_bc = closest_on_edge(p, b, c - b);
  Closest<Real> best{squared_length(ap - t_ab * ab), t_ab, Real(0)};
  keep_closer(best, {squared_length(ap - t_ac * ac), Real(0), t_ac});
  keep_closer(best, {squared_length(p - (b + t_bc * (c - b))), Real(1) - t_bc, t_bc});
  return best;
}

/// The foot of a vertex on the plane of a triangle, if it is inside; n = cross(ab, ac), n2 = dot(n, n).
template <class Real>
COLLIDED_HD Weights<Real> foot_on_plane(const Vec3<Real>& ap, const Vec3<Real>& ab, const Vec3<Real>& ac,
                                        const Vec3<Real>& n, Real n2) {
  const Mask<Real> has_plane = n2 > 0;
  if (!any(has_plane)) return {Real(0), Real(0), has_plane};
  const Real v = dot(cross(ap, ac), n) / n2, w = dot(cross(ab, ap), n) / n2;
  const Mask<Real> inside = has_plane && v >= 0 && w >= 0 && v + w <= 1;
  return {v, w, inside};
}

/// Vertex p against triangle a b c.
template <class Real>
COLLIDED_HD Closest<Real> closest_vertex_triangle(const Vec3<Real>& p, const Vec3<Real>& a, const Vec3<Real>& b,
                                                  const Vec3<Real>& c) {
  const Vec3<Real> ab = b - a, ac = c - a, ap = p - a, n = cross(ab, ac);
  Closest<Real> best = closest_on_border(p, a, b, c);
  const Real n2 = dot(n, n);
  const Weights<Real> foot = foot_on_plane(ap, ab, ac, n, n2);
  if (any(foot.inside)) {
    const Real height = dot(ap, n);
    const Closest<Real> of_foot{height * height / n2, foot.w0, foot.w1};
    keep_if<Real>(foot.inside && of_foot.squared < best.squared, best, of_foot);
  }
  return best;
}

/// Edge a0 a1 against edge b0 b1.
template <class Real>
COLLIDED_HD Closest<Real> closest_edge_edge(const Vec3<Real>& a0, const Vec3<Real>& a1, const Vec3<Real>& b0,
                                            const Vec3<Real>& b1) {
  const Vec3<Real> d = a1 - a0, e = b1 - b0, r = a0 - b0;
  Real t = closest_on_edge(a0, b0, e);
  Closest<Real> best{squared_length(r - t * e), Real(0), t};
  t = closest_on_edge(a1, b0, e);
  keep_closer(best, {squared_length(a1 - (b0 + t * e)), Real(1), t});
  t = closest_on_edge(b0, a0, d);
  keep_closer(best, {squared_length((a0 + t * d) - b0), t, Real(0)});
  t = closest_on_edge(b1, a0, d);
  keep_closer(best, {squared_length((a0 + t * d) - b1), t, Real(1)});
  const Vec3<Real> n = cross(d, e);
  const Real n2 = dot(n, n);
  const Mask<Real> crossing = n2 > 0;
  if (any(crossing)) {
    const Real s = dot(cross(e, r), n) / n2, u = dot(cross(d, r), n) / n2;
    const Mask<Real> inside = crossing && s >= 0 && s <= 1 && u >= 0 && u <= 1;
    if (any(inside)) {
      const Real height = dot(r, n);
      const Closest<Real> of_crossing{height * height / n2, s, u};
      // The height is precise. The weights of edges that are nearly parallel may be off by far more than it.
      const Real between = squared_length((r + s * d) - u * e);
      const Mask<Real> is_closer = inside && of_crossing.squared < best.squared;
      keep_if<Real>(is_closer && between < best.squared, best, of_crossing);
      best.squared = select(is_closer, of_crossing.squared, best.squared);
    }
  }
  return best;
}

/// As closest_vertex_triangle with `n` = cross(b - a, c - a), in fewer operations where the vertex is above the
/// triangle. Slivers may give points that are a little off.
template <class Real>
COLLIDED_HD Weights<Real> nearly_closest_vertex_triangle(const Vec3<Real>& ap, const Vec3<Real>& ab,
                                                         const Vec3<Real>& ac, const Vec3<Real>& n) {
  const Weights<Real> foot = foot_on_plane(ap, ab, ac, n, dot(n, n));
  if (all(foot.inside)) return foot;
  const Closest<Real> border = closest_on_border(ap, Vec3<Real>{0, 0, 0}, ab, ac);
  return {select(foot.inside, foot.w0, border.w0), select(foot.inside, foot.w1, border.w1), foot.inside};
}

/// As closest_edge_edge for edges d and e, r = a0 - b0 and `n` = cross(d, e), in fewer operations (Ericson 2005,
/// section 5.1.9). Edges that are nearly parallel may give points that are a little off.
template <class Real>
COLLIDED_HD Weights<Real> nearly_closest_edge_edge(const Vec3<Real>& r, const Vec3<Real>& d, const Vec3<Real>& e,
                                                   const Vec3<Real>& n) {
  const Real n2 = dot(n, n), d2 = dot(d, d), e2 = dot(e, e), er = dot(e, r);
  Real s = replace_where(n2 > 0, Real(0), [&] { return clamp01(dot(cross(e, r), n) / n2); });
  const Real along = er + s * dot(d, e);
  const Real t = replace_where(e2 > 0, Real(0), [&] { return clamp01(along / e2); });
  const Mask<Real> within = along > 0 && along <= e2;  // never so on an edge of length zero
  s = replace_where(!within && d2 > 0, s, [&] { return clamp01(dot(d, t * e - r) / d2); });
  const Mask<Real> inside = s > 0 && s < 1 && t > 0 && t < 1;
  return {s, t, inside};
}

}  // namespace collided
