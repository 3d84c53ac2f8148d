#pragma once
// Normals of contacts: unit, from the second feature to the first, at the time of the contact.
//
// p and q are the closest points of the first and of the second feature, w is how far p moves against q in the whole
// step (0 in DCD), and "clear" is more than 2^-26 of what the features extend over.
//   1. If p and q are clearly apart: (p - q) / |p - q|.
//   2. Else n / |n| or -n / |n| with the features' common normal n, (b - a) x (c - a) of triangle a b c or
//      (a1 - a0) x (b1 - b0) of two edges, if |n| is clear: the one that points to where the first feature came from,
//      against w; if it does not move across the second, the one along p - q; n itself if p = q.
//   3. Else -w across the features' longest edge, if it is clear.
//   4. Else a direction across that edge: its cross product with the axis that it follows least; z if it is a point.

#include "gpu/base/keys.hpp"
#include "gpu/narrow/differences.hpp"

namespace collided {

namespace detail {

COLLIDED_HD inline double length_of(const Vec3<double>& v) { return std::sqrt(dot(v, v)); }

/// `v` without what it has along `axis`.
COLLIDED_HD inline Vec3<double> across(const Vec3<double>& v, const Vec3<double>& axis) {
  const double squared = dot(axis, axis);
  return squared > 0 ? v - (dot(v, axis) / squared) * axis : v;
}

COLLIDED_HD inline Vec3<double> any_across(const Vec3<double>& edge) {
  const double x = magnitude(edge.x), y = magnitude(edge.y), z = magnitude(edge.z);
  if (x <= y && x <= z) return cross(edge, Vec3<double>{1, 0, 0});
  return y <= z ? cross(edge, Vec3<double>{0, 1, 0}) : cross(edge, Vec3<double>{0, 0, 1});
}

/// Of any length but 0. `gap` = p - q, `moved` = w, in units of about what the features extend over.
COLLIDED_HD inline Vec3<double> direction_between(const SpanningEdges<double>& edges, const Gap<double>& gap,
                                                  const Vec3<double>& moved, double clear) {
  if (gap.length > clear) return gap.vector;
  const Vec3<double> n = normal_of(edges);
  const double e = length_of(edges.first), f = length_of(edges.second);
  if (length_of(n) > clear * e * f) {
    const double side = dot(n, moved) != 0 ? -dot(n, moved) : dot(n, gap.vector);
    return side < 0 ? -1.0 * n : n;
  }
  const Vec3<double> edge = e < f ? edges.second : edges.first, against = across(-1.0 * moved, edge);
  if (length_of(against) > clear) return against;
  return length_of(edge) > 0 ? any_across(edge) : Vec3<double>{0, 0, 1};
}

}  // namespace detail

constexpr double kClear = 0x1p-26, kClearInFloat = 0x1p-16;

/// Of two features with these differences, in contact at time t.
template <int N>
COLLIDED_HD Vec3<double> contact_normal(const Differences<double, N>& d, double t, double clear) {
  Vec3<double> x[N], moved[N];
  differences_at(d, t, x);
  for (int k = 0; k < N; ++k) moved[k] = d.end[k] - d.start[k];
  const Gap<double> gap = gap_between(x);
  const Vec3<double> direction =
      detail::direction_between(spanning_edges(x), gap, between_points(moved, gap.points.w0, gap.points.w1), clear);
  return (1 / detail::length_of(direction)) * direction;
}

/// Of a contact of this kind at time t.
template <class Kind, class Real>
COLLIDED_HD Normal contact_normal(const FeaturePoints<Real>& points, double t, double clear) {
  DifferencesOf<double, Kind> d;
  if (!load_differences<Kind, double>(points, d)) return {0, 0, 1};  // all is one point
  const Vec3<float> n = convert<float>(contact_normal(d, t, clear));
  return {n.x, n.y, n.z};
}

/// The normals of a list's contacts; those of triangle pairs are not looked at.
template <class Real>
struct WriteNormals {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  FeatureKinds kinds;
  FeatureRanks ranks;
  double clear;
  Span<const uint64_t> keys;
  Span<const ContactData<Real>> data;
  Span<Normal> normals;

  COLLIDED_HD void operator()(uint64_t i) const {
    use_contact(kinds, ranks, keys[i],
                [&](const auto& kind, uint64_t key) { normals[i] = normal_of(kind, key, data[i].toi); });
  }

 private:
  template <class Kind>
  COLLIDED_HD Normal normal_of(const Kind& kind, uint64_t key, double t) const {
    return contact_normal<Kind>(points_of(kind.stencil(key), start, end), t, clear);
  }
};

}  // namespace collided
