#pragma once
// Two features seen through the differences of their vertices, x_i - y_j for every vertex i of one and j of the
// other: separation, closest points and coplanarity depend on nothing else. Differences of neighbours keep the digits
// that coordinates far from the origin would waste, and a power of two brings them near 1, so that no bound has to
// fear overflow and tiny scenes behave as others do.
//
// Each component is the true difference times the scale, within one rounding error of the working precision
// (two for double positions in float, which 8u below covers too).

#include "gpu/base/precision.hpp"
#include "gpu/narrow/features.hpp"

namespace collided {

template <class Work, int N>
struct Differences {
  Vec3<Work> start[N], end[N];  ///< at t = 0 and t = 1
  Work extent;                  ///< largest component; below 2
  DoubleOf<Work> scale;         ///< what the true differences were multiplied by

  COLLIDED_HD Vec3<Work> at(int k, Work t) const { return (1 - t) * start[k] + t * end[k]; }
};

template <class Work, class Kind>
using DifferencesOf = Differences<Work, DifferenceOf<Kind>::kCount>;

/// False if all vertices coincide at both ends, so that there is nothing to scale.
template <class Kind, class Work, class Real>
COLLIDED_HD Mask<Wider<Work, Real>> load_differences(const FeaturePoints<Real>& p, DifferencesOf<Work, Kind>& out) {
  using Wide = Wider<Work, Real>;  // differences are formed before anything is rounded to the working type
  constexpr int n = DifferenceOf<Kind>::kCount;
  Vec3<Wide> x[n], y[n];
  Wide extent = 0;
  for (int k = 0; k < n; ++k) {
    const int i = DifferenceOf<Kind>::minuend(k), j = DifferenceOf<Kind>::subtrahend(k);
    x[k] = convert<Wide>(p.start[i]) - convert<Wide>(p.start[j]);
    y[k] = convert<Wide>(p.end[i]) - convert<Wide>(p.end[j]);
    extent = max(extent, max(largest_component(x[k]), largest_component(y[k])));
  }
  const Mask<Wide> differ = extent != 0;
  if (!any(differ)) return differ;
  const Wide scale = unit_scale(extent);
  for (int k = 0; k < n; ++k) {
    out.start[k] = convert<Work>(scale * x[k]);
    out.end[k] = convert<Work>(scale * y[k]);
  }
  out.extent = static_cast<Work>(scale * extent);
  out.scale = static_cast<DoubleOf<Work>>(scale);
  return differ;
}

template <class Work, int N>
COLLIDED_HD void differences_at(const Differences<Work, N>& d, Work t, Vec3<Work> (&x)[N]) {
  for (int k = 0; k < N; ++k) x[k] = d.at(k, t);
}

/// Closest points of the features, and the vector between them, scaled.
template <class Work>
struct Gap {
  Closest<Work> points;
  Vec3<Work> vector;
  Work length;
};

template <class Work, int N>
COLLIDED_HD Gap<Work> gap_between(const Vec3<Work> (&x)[N]) {
  const Closest<Work> points = closest_points(x);
  const Vec3<Work> vector = between_points(x, points.w0, points.w1);
  return {points, vector, square_root(dot(vector, vector))};
}
template <class Work, int N>
COLLIDED_HD Gap<Work> gap_at(const Differences<Work, N>& d, Work t) {
  Vec3<Work> x[N];
  differences_at(d, t, x);
  return gap_between(x);
}

/// Normal of the triangle, or of both edges; zero if they have none.
template <class Work>
COLLIDED_HD Vec3<Work> normal_of(const SpanningEdges<Work>& edges) {
  return cross(edges.first, edges.second);
}
template <class Work, int N>
COLLIDED_HD Vec3<Work> common_normal(const Vec3<Work> (&d)[N]) {
  return normal_of(spanning_edges(d));
}

}  // namespace collided
