#pragma once
// Normals of contacts: unit, from the second feature to the first, at the time of the contact, against the approach.
//
// p and q are the closest points of the first and of the second feature, w is how far p moves against q in the whole
// step (0 in DCD), n is the features' common normal, (b - a) x (c - a) of triangle a b c or (a1 - a0) x (b1 - b0) of
// two edges, and "clear" is more than 2^-26 of what the features extend over.
//   1. If p and q are clearly apart: (p - q) / |p - q|.
//      Else, in a frame of DCD that tells features: the normal that supports both surfaces (support_normal.hpp), if
//      there is one.
//   2. Else n / |n| or -n / |n|, against w, if |n| is clear and w is more than 2^-10 off the plane across n.
//   3. Else p - q when they were last clearly apart, if it separates the features at the contact but for what is not
//      clear, and opposes w; else of the directions of near_miss.hpp that do so the one closest to it.
//   4. Else n / |n| or -n / |n|, if |n| is clear: to the side of p - q when they were last clearly apart, else against
//      w, else along p - q; n itself if p = q.
//   5. Else -w across the features' longest edge, if it is clear.
//   6. Else a direction across that edge: its cross product with the axis that it follows least; z if it is a point.
//
// A direction c that separates the features a time s before the contact opposes the approach: c . (D_k - s w_k) > 0 for
// all differences D_k; with the weights of the contact's points they add up to 0 at the contact, so that c . w < 0.
// The normal n alone does not do where all motion is in one plane: it is across w, and separates nothing.

#include "gpu/base/keys.hpp"
#include "gpu/narrow/near_miss.hpp"
#include "gpu/narrow/support_normal.hpp"

namespace collided {

namespace detail {

COLLIDED_HD inline double length_of(const Vec3<double>& v) { return std::sqrt(dot(v, v)); }

COLLIDED_HD inline Vec3<double> any_across(const Vec3<double>& edge) {
  const double x = magnitude(edge.x), y = magnitude(edge.y), z = magnitude(edge.z);
  if (x <= y && x <= z) return cross(edge, Vec3<double>{1, 0, 0});
  return y <= z ? cross(edge, Vec3<double>{0, 1, 0}) : cross(edge, Vec3<double>{0, 0, 1});
}

/// The normal of the features tells the approach if w leaves the plane across it by more than this sine.
constexpr double kAcross = 0x1p-10;

/// The features at a contact. `clear`: of what they extend over.
template <int N>
class Touching {
 public:
  COLLIDED_HD Touching(const Differences<double, N>& d, double t, double clear)
      : d_(d), t_(t), sine_(clear), clear_(clear * d.extent) {
    differences_at(d, t, x_);
    gap_ = gap_between(x_);
    w_ =
        between_points(d.end, gap_.points.w0, gap_.points.w1) - between_points(d.start, gap_.points.w0, gap_.points.w1);
  }

  /// Returns the normal, of any length but 0.
  COLLIDED_HD Vec3<double> normal() const {
    if (gap_.length > clear_) return gap_.vector;
    const SpanningEdges<double> edges = spanning_edges(x_);
    const Vec3<double> n = normal_of(edges);
    const double e = length_of(edges.first), f = length_of(edges.second), size = length_of(n), w = length_of(w_);
    const bool has_normal = size > sine_ * e * f;
    double side = -dot(n, w_);
    if (!has_normal || magnitude(side) <= kAcross * size * w) {
      const Vec3<double> before = gap_before();
      if (separates(before)) return before;
      const Direction<double> direction = closest_to(before);
      if (direction.length > 0) return direction.n;
      if (dot(n, before) != 0) side = dot(n, before);
    }
    if (has_normal) return (side != 0 ? side : dot(n, gap_.vector)) < 0 ? -1.0 * n : n;
    const Vec3<double> edge = e < f ? edges.second : edges.first, against = reject(-1.0 * w_, edge);
    if (length_of(against) > clear_) return against;
    return length_of(edge) > 0 ? any_across(edge) : Vec3<double>{0, 0, 1};
  }

 private:
  /// Returns the vector between the closest points when the features were last clearly apart; 0 if they do not move.
  /// It looks back by about the time that the fastest vertex takes to move `clear`, then twice as far each time, up to
  /// a whole step. Before t = 0 the motion is extrapolated.
  COLLIDED_HD Vec3<double> gap_before() const {
    double speed = 0;
    for (int k = 0; k < N; ++k) speed = max(speed, largest_component(d_.end[k] - d_.start[k]));
    for (double back = 2 * clear_ / speed; back <= 1; back *= 2) {
      const Gap<double> gap = gap_at(d_, t_ - back);
      if (gap.length > clear_) return gap.vector;
    }
    return {0, 0, 0};
  }
  /// True if the direction opposes w and separates the features at the contact but for what is not clear.
  COLLIDED_HD bool separates(const Vec3<double>& direction) const {
    const double least = -2 * clear_ * length_of(direction);
    for (int k = 0; k < N; ++k)
      if (!(dot(direction, x_[k]) >= least)) return false;
    return dot(direction, w_) < 0;
  }
  /// The one closest to `before` of the precise directions that separate the features, among them its rejections; no
  /// direction if there is none.
  COLLIDED_HD Direction<double> closest_to(const Vec3<double>& before) const {
    PreciseDirections<double, N> directions(d_, t_);
    directions.replace_gap(before);
    Direction<double> best{{0, 0, 0}, 0};
    double most = 0;
    for (uint32_t k = 0; k < directions.kCount; ++k) {
      Direction<double> direction = directions[k];
      if (dot(direction.n, before) < 0) direction.n = -1.0 * direction.n;
      const double likeness = direction.length > 0 ? dot(direction.n, before) / direction.length : 0;
      if (likeness > most && separates(direction.n)) most = likeness, best = direction;
    }
    return best;
  }

  const Differences<double, N>& d_;
  double t_;
  double sine_;   ///< of edges that are clearly not parallel
  double clear_;  ///< length
  Vec3<double> x_[N], w_;
  Gap<double> gap_;
};

}  // namespace detail

constexpr double kClear = 0x1p-26, kClearInFloat = 0x1p-16;

/// Of two features with these differences, in contact at time t.
template <int N>
COLLIDED_HD Vec3<double> contact_normal(const Differences<double, N>& d, double t, double clear) {
  // Features may be so small against the pair's extent that the square of their normal underflows.
  const Direction<double> normal = direction_of(detail::Touching<N>(d, t, clear).normal());
  return (1 / normal.length) * normal.n;
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
  Surfaces<Real> surfaces;  ///< of DCD; may be unknown

  COLLIDED_HD void operator()(uint64_t i) const {
    use_contact(kinds, ranks, keys[i],
                [&](const auto& kind, uint64_t key) { normals[i] = normal_of(kind, key, data[i].toi); });
  }

 private:
  template <class Kind>
  COLLIDED_HD Normal normal_of(const Kind& kind, uint64_t key, double t) const {
    const Stencil stencil = kind.stencil(key);
    if (surfaces.fans.are_known()) {
      const Vec3<double> n = support_normal(surfaces, kind, stencil, clear);
      if (dot(n, n) > 0) return {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
    }
    return contact_normal<Kind>(points_of(stencil, start, end), t, clear);
  }
};

}  // namespace collided
