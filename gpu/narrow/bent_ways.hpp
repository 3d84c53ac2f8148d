#pragma once
// Bounds the ways of pairs whose rigid meshes turn. Vertices of such a mesh go along arcs. A known bound says how far
// an arc is off the straight way between its ends (base/mesh_turns.hpp). A pair has up to three views, and any of them
// may be used:
// - The scene's own. The distance of the arcs differs from that of the straight ways by the bounds of both features.
// - That of either mesh, if both turn. The mesh stands still there, and so does whatever turns with it.
//
// Seen from a mesh. Let two meshes move at even speed along screws of angular velocities w1 and w2. Velocities at a
// point p are v1(p) and v2(p), and u = v1 - v2. A difference of vertices p1 of the first and p2 of the second mesh,
// seen from the second, is r(t) = M(t) (p1 - p2), where M(t) turns by -t |w2| about w2. Its derivatives are
//   r' = M u(p1),   r'' = M ((w1 - w2) x v1(p1) - w2 x u(p1)),
// for the frame's own turning takes away what w2 x (p1 - p2) adds to the difference of both velocities. Let K be the
// greatest |r''|, and e = |r(1) - r(0)|. The mean of r' is r(1) - r(0), and so |u| = |r'| is at most e + K / 2 all
// along:
//   K <= |w1 - w2| |v1| + |w2| (e + K / 2),   K (1 - |w2| / 2) <= |w1 - w2| |v1| + |w2| e.
// A curve with |r''| <= K is within K / 8 of its chord. All differences of points of the features are weighted means of
// those of their vertices, and so within the greatest of these bounds.
//
// Angular velocities are known by s = sin(angle / 2) times the axis. For angles up to 1, |w| <= 2.09 |s|, and
// |w1 - w2| <= 2.28 |s1 - s2|; |v| is at most 1.05 times the vertex's chord. R off a rotation by up to e moves s by at
// most 3 e.

#include "gpu/base/mesh_turns.hpp"
#include "gpu/narrow/certified_way.hpp"

namespace collided {

/// Holds the differences of a pair, as a view has them. On the true way they are off the straight lines between these
/// by `off` at most, in the unit of the positions.
template <int N>
struct BentWay {
  Differences<double, N> d;
  double off;
};

namespace detail {

/// Holds how far the vertices of each feature go at most.
struct Chords {
  double first = 0, second = 0;

  template <class Kind, class Real>
  COLLIDED_HD static Chords of(const FeaturePoints<Real>& way) {
    double first = 0, second = 0;
    for (int k = 0; k < 4; ++k) {
      const Vec3<double> chord = convert<double>(way.end[k]) - convert<double>(way.start[k]);
      double& most = k < DifferenceOf<Kind>::kOfFirst ? first : second;
      most = max(most, dot(chord, chord));
    }
    constexpr double kRoundings = 1 + 8 * Precision<double>::kUnit;
    return {kRoundings * square_root(first), kRoundings * square_root(second)};
  }
};

/// Returns how far vertices of a mesh may be off their straight ways. They go no farther than `chord`, between rounded
/// positions.
COLLIDED_HD inline double off_straight(const MeshTurn* turn, double chord) {
  if (turn == nullptr) return 0;
  const double of_these = turn->bend * (chord + 2 * turn->rounded) + turn->rounding;
  return min(turn->deviation, of_these * (1 + 8 * Precision<double>::kUnit));
}

/// Returns the same of both features together.
COLLIDED_HD inline double off_straight(const PairTurn& turn, const Chords& chords) {
  return Deviations::widened(off_straight(turn.first, chords.first), off_straight(turn.second, chords.second));
}

COLLIDED_HD inline double sine_of_half(const MeshTurn& turn) {
  return square_root(dot(turn.half_turn, turn.half_turn));
}
/// Meshes of which one turns by more than this says are not seen from each other.
constexpr double kMostSineOfHalf = 0.4794;
/// Returns the sine of half the greater angle, of meshes that both turn.
COLLIDED_HD inline double greater_sine_of_half(const PairTurn& turn) {
  return max(sine_of_half(*turn.first), sine_of_half(*turn.second));
}

/// Returns a way as the mesh that turns by `by` sees it. The other feature's mesh turns by `other`, and its vertices go
/// no farther than `chord`.
template <int N>
COLLIDED_HD BentWay<N> seen_from(const MeshTurn& by, const MeshTurn& other, double chord, Differences<double, N> d) {
  constexpr double u = Precision<double>::kUnit;
  double squared = 0, largest = 0, extent = 0;
  for (int k = 0; k < N; ++k) {  // half as long: turning must not bring a component to 2
    d.start[k] = 0.5 * d.start[k], d.end[k] = 0.5 * by.turned_back(d.end[k]);
    const Vec3<double> change = d.end[k] - d.start[k];
    squared = max(squared, dot(change, change));
    largest = max(largest, dot(d.end[k], d.end[k]));
    extent = max(extent, max(largest_component(d.start[k]), largest_component(d.end[k])));
  }
  d.extent = extent, d.scale = 0.5 * d.scale;

  const Vec3<double> apart = other.half_turn - by.half_turn;
  const double rounded = by.rounded + other.rounded, unscaled = 1 / d.scale;
  const double lost = unscaled * square_root(largest) * (2 * by.defect + 64 * u);
  const double changed = unscaled * square_root(squared) + lost + 2 * rounded;
  const double turned = 2.09 * (sine_of_half(by) + 3 * by.defect);
  const double turned_apart = 2.28 * (square_root(dot(apart, apart)) + 3 * (by.defect + other.defect));
  const double speed = 1.05 * (chord + 2 * other.rounded);
  const double bend = (turned_apart * speed + turned * changed) / (1 - turned / 2);
  return {d, (bend / 8 + lost + by.rounding + other.rounding) * (1 + 64 * u)};
}

template <int N>
COLLIDED_HD BentWay<N> better_of(const BentWay<N>& a, const BentWay<N>& b) {
  return b.off < a.off ? b : a;
}

}  // namespace detail

/// Returns the best view of a pair. `d`: its differences as they are.
template <class Kind, class Real, int N>
COLLIDED_HD BentWay<N> bent_way(const FeaturePoints<Real>& way, const Differences<double, N>& d, const PairTurn& turn) {
  if (turn.is_straight()) return {d, 0};
  const detail::Chords chords = detail::Chords::of<Kind>(way);
  BentWay<N> best{d, detail::off_straight(turn, chords)};
  if (!turn.both() || !(detail::greater_sine_of_half(turn) < detail::kMostSineOfHalf)) return best;
  best = detail::better_of(best, detail::seen_from(*turn.second, *turn.first, chords.first, d));
  return detail::better_of(best, detail::seen_from(*turn.first, *turn.second, chords.second, d));
}

}  // namespace collided
