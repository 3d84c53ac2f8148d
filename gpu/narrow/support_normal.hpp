#pragma once
// Finds the normal of two features that touch in one frame from the surfaces around them. The formula of normal.hpp
// knows the two features alone: where boxes lie flush, an edge of each may have any common normal.
//
// A normal n supports both surfaces if n.d >= 0 for all directions d into the first surface, and n.d <= 0 for all into
// the second, each to within a slack. The first candidate that does so is the contact's normal. Candidates are the
// normals of the second's triangles at the contact, in the order of their ids; then those of the first's; then the
// common normals of any two directions. At a corner, directions go along its sides; on a side, both ways along it and
// to the opposite corners of its triangles; on a face, both ways along two of its sides. A point is taken to lie on a
// corner or side that it is within `clear` of (normal.hpp), because rounding may put it beside.

#include "gpu/narrow/near_miss.hpp"
#include "gpu/narrow/surfaces.hpp"

namespace collided {

template <class Real>
class SupportNormal {
 public:
  /// `corners`: of the triangle, where one of the features is a face.
  COLLIDED_HD SupportNormal(const Surfaces<Real>& surfaces, const NamedPair& touching, const Vec3<uint32_t>& corners,
                            double slack)
      : surfaces_(surfaces), first_(touching.first), second_(touching.second), corners_(corners), slack_(slack) {}

  /// Returns a unit vector; 0 if no direction that is asked supports both surfaces.
  COLLIDED_HD Vec3<double> find() const {
    Vec3<double> found = {0, 0, 0};
    if (is_crowded(first_) || is_crowded(second_)) return found;
    const auto take = [&](const Vec3<double>& a, const Vec3<double>& b) {
      const Vec3<double> n = cross(a, b);
      const double n2 = dot(n, n);
      if (!(n2 > slack_ * slack_ * dot(a, a) * dot(b, b))) return false;
      const Vec3<double> unit = (1 / std::sqrt(n2)) * n;
      for (const double sign : {1.0, -1.0}) {
        found = sign * unit;
        if (supports(found)) return true;
      }
      found = {0, 0, 0};
      return false;
    };
    if (any_face(second_, take) || any_face(first_, take)) return found;
    any_direction(
        [&](const Vec3<double>& a) { return any_direction([&](const Vec3<double>& b) { return take(a, b); }); });
    return found;
  }

 private:
  static constexpr uint32_t kMostElements = 32;  ///< around a point: all pairs of directions are asked

  COLLIDED_HD bool is_crowded(const NamedFeature& at) const {
    return at.count < 3 && surfaces_.count_elements(at) > kMostElements;
  }
  COLLIDED_HD bool supports(const Vec3<double>& n) const {
    const auto opposes = [&](const Vec3<double>& d, double side) {
      return side * dot(n, d) < -slack_ * std::sqrt(dot(d, d));
    };
    return !any_direction(first_, [&](const Vec3<double>& d) { return opposes(d, 1); }) &&
           !any_direction(second_, [&](const Vec3<double>& d) { return opposes(d, -1); });
  }
  /// take(two sides) of each triangle there, until it returns true.
  template <class Take>
  COLLIDED_HD bool any_face(const NamedFeature& at, const Take& take) const {
    bool done = false;
    for_each_element(at, [&](const Vec3<uint32_t>& t) {
      done = t.y != t.z && take(surfaces_.along(t.x, t.y), surfaces_.along(t.x, t.z));
      return !done;
    });
    return done;
  }
  template <class Use>
  COLLIDED_HD void for_each_element(const NamedFeature& at, const Use& use) const {
    if (at.count == 3)
      use(corners_);
    else
      surfaces_.for_each_element(at, use);
  }
  /// use(d) for each direction into both surfaces, until it returns true.
  template <class Use>
  COLLIDED_HD bool any_direction(const Use& use) const {
    return any_direction(first_, use) || any_direction(second_, use);
  }
  /// The same of one surface.
  template <class Use>
  COLLIDED_HD bool any_direction(const NamedFeature& at, const Use& use) const {
    const auto use_both_ways = [&](const Vec3<double>& d) { return use(d) || use(-1.0 * d); };
    if (at.count == 3)
      return use_both_ways(surfaces_.along(at.v[0], at.v[1])) || use_both_ways(surfaces_.along(at.v[0], at.v[2]));
    if (at.count == 2 && use_both_ways(surfaces_.along(at.v[0], at.v[1]))) return true;
    bool done = false;
    for_each_element(at, [&](const Vec3<uint32_t>& t) {
      const uint32_t v = at.v[0], w = at.count == 2 ? at.v[1] : other_corner(t, v), last = third_corner(t, v, w);
      done = (at.count == 1 && use(surfaces_.along(v, w))) || (t.y != t.z && use(surfaces_.along(v, last)));
      return !done;
    });
    return done;
  }

  const Surfaces<Real>& surfaces_;
  NamedFeature first_, second_;
  Vec3<uint32_t> corners_;
  double slack_;
};

namespace detail {

/// As FeatureBits: the corner or side that the vertex is within `clear` of, given its differences to the corners.
COLLIDED_HD inline uint8_t snapped_features(const Vec3<double> (&x)[3], const Closest<double>&, double clear) {
  for (int k = 0; k < 3; ++k)
    if (dot(x[k], x[k]) <= clear * clear) return static_cast<uint8_t>(4 + k);
  for (int k = 0; k < 3; ++k) {
    const Vec3<double> off = reject(x[(k + 1) % 3], x[(k + 1) % 3] - x[(k + 2) % 3]);
    if (dot(off, off) <= clear * clear) return static_cast<uint8_t>(1 + k);
  }
  return 0;
}
/// The same of the ends of two edges.
COLLIDED_HD inline uint8_t snapped_features(const Vec3<double> (&x)[4], const Closest<double>& at, double clear) {
  const SpanningEdges<double> edges = spanning_edges(x);
  const auto end = [&](const Vec3<double>& edge, double along) {
    const double length = std::sqrt(dot(edge, edge));
    return along * length <= clear ? 1 : (1 - along) * length <= clear ? 2 : 0;
  };
  return static_cast<uint8_t>(end(edges.first, at.w0) | end(edges.second, at.w1) * 4);
}

}  // namespace detail

/// The normal of a contact of one frame whose points are not clearly apart, a unit vector; 0 if they are, or if there
/// is none. `clear`: of what the features extend over.
template <class Kind, class Real>
COLLIDED_HD COLLIDED_CALLED Vec3<double> support_normal(const Surfaces<Real>& surfaces, const Kind& kind,
                                                        const Stencil& stencil, double clear) {
  DifferencesOf<double, Kind> d;
  const FeaturePoints<Real> points = points_of(stencil, surfaces.positions, surfaces.positions);
  if (!load_differences<Kind, double>(points, d)) return {0, 0, 0};
  const Gap<double> gap = gap_between(d.end);
  const double length = clear * d.extent;
  if (gap.length > length) return {0, 0, 0};
  const NamedPair touching = named_features(kind, stencil, detail::snapped_features(d.end, gap.points, length));
  return SupportNormal<Real>(surfaces, touching, {stencil.v[1], stencil.v[2], stencil.v[3]}, clear).find();
}

}  // namespace collided
