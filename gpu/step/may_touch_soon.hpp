#pragma once
// Which pairs of features the lists of neighbours hold: those that are not certain to keep so far apart, on their
// tracks and within the margin of them, that the narrow phase of every frame there tells them apart at its first look.
// What it cannot tell apart it reports, near or not, so that a pair must not be left out only because it does not
// touch.
//
// The features' straight paths go from where this frame begins to where the tracks end, as in one long step; a
// direction that keeps them apart over it does so in each frame. Of the distance that it has to keep,
// - each of two vertices may be off its track by the margin, and while a frame lasts they move against each other by
//   `drift` and half a margin each: three margins;
// - an eighth of the pair's size is far more than float loses in the closest points of features that are well shaped,
//   whose directions the narrow phase looks along: a triangle whose height is a 32nd of its sides, edges that are not
//   nearly parallel. Exactly parallel edges and degenerate triangles are listed.

#include "gpu/narrow/certified_ccd.hpp"

namespace collided {

template <class Real>
struct MayTouchSoon {
  double thickness;  ///< the largest contact distance, and what encoded positions are off
  Deviations deviations;
  double delta, margin;
  double frames;  ///< from the beginning of this one to the end of the tracks

  template <class Kind>
  COLLIDED_HD bool operator()(const Kind&, const FeaturePoints<Real>& points) const {
    DifferencesOf<float, Kind> d;
    if (!load_differences<Kind, float>(points, d) || !is_well_shaped<Kind>(d)) return true;
    const double reach = Deviations::widened(thickness, deviations.of_any_pair());
    const double size = d.extent / d.scale, drift = drift_of(d) / (frames * d.scale);
    const double needed = reach + delta + kMargins * margin + drift + size / 8;
    return !apart_all_along(d, direction_of(gap_at(d, 0.5f).vector), scaled_thickness<float>(needed, d.scale));
  }

 private:
  static constexpr double kMargins = 3.01;

  /// How far a vertex of one moves against one of the other, at most, scaled.
  template <int N>
  COLLIDED_HD static double drift_of(const Differences<float, N>& d) {
    double most = 0;
    for (int k = 0; k < N; ++k) {
      const Vec3<float> way = d.end[k] - d.start[k];
      most = max(most, static_cast<double>(dot(way, way)));
    }
    return 1.001 * std::sqrt(most);
  }
  /// All along: with n_0, n_1, n_2 the Bernstein coefficients of the normal, all of them along n_1.
  template <class Kind, int N>
  COLLIDED_HD bool is_well_shaped(const Differences<float, N>& d) const {
    const SpanningEdges<float> x = spanning_edges(d.start), y = spanning_edges(d.end);
    const Vec3<float> middle = 0.5f * (cross(x.first, y.second) + cross(y.first, x.second));
    const float first = std::sqrt(max(dot(x.first, x.first), dot(y.first, y.first))),
                second = std::sqrt(max(dot(x.second, x.second), dot(y.second, y.second)));
    constexpr float kLeast = std::is_same_v<Kind, VertexTriangle> ? 0x1p-5f : 0x1p-11f;
    const float off = static_cast<float>(margin * d.scale);
    const float least = (kLeast * first * second + 4 * off * (first + second)) * std::sqrt(dot(middle, middle));
    return least > 0 && dot(cross(x.first, x.second), middle) > least && dot(middle, middle) > least &&
           dot(cross(y.first, y.second), middle) > least;
  }
};

}  // namespace collided
