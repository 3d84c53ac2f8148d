#pragma once
// Ways of pairs with rigid meshes that turn. Their vertices go along arcs; the straight ways between the ends are off
// these by known bounds (base/mesh_turns.hpp). Two views of a pair are tried, and each is right:
// - As it is: what the straight ways of both features are apart, the arcs are apart to within both deviations.
// - From the second feature's mesh, which stands still there: meshes that turn together do not move at all.
//
// The second view. Let both meshes move at even speed along screws of angular velocities w1 and w2. Velocities at a
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
// |w1 - w2| <= 2.28 |s1 - s2|.

#include "gpu/base/mesh_turns.hpp"
#include "gpu/narrow/certified_way.hpp"

namespace collided {

/// The differences of a pair on its ways, and what these may be off, in the unit of the positions.
template <int N>
struct BentWay {
  Differences<double, N> d;
  double off;
};

namespace detail {

/// As the second mesh sees them. False if they turn by more than the bounds above are for.
template <int N>
COLLIDED_HD bool see_from_second(const PairTurn& turn, BentWay<N>& way) {
  constexpr double kMostSine = 0.479;  // of half a radian
  constexpr double u = Precision<double>::kUnit;
  const MeshTurn &first = *turn.first, &second = *turn.second;
  const double half = square_root(dot(second.half_turn, second.half_turn)),
               half_of_first = square_root(dot(first.half_turn, first.half_turn));
  if (!(half < kMostSine && half_of_first < kMostSine)) return false;

  Differences<double, N>& d = way.d;
  double squared = 0, largest = 0, extent = 0;
  for (int k = 0; k < N; ++k) {  // half as long: turning must not bring a component to 2
    d.start[k] = 0.5 * d.start[k], d.end[k] = 0.5 * second.turned_back(d.end[k]);
    const Vec3<double> change = d.end[k] - d.start[k];
    squared = max(squared, dot(change, change));
    largest = max(largest, dot(d.end[k], d.end[k]));
    extent = max(extent, max(largest_component(d.start[k]), largest_component(d.end[k])));
  }
  d.extent = extent, d.scale = 0.5 * d.scale;

  const Vec3<double> apart = first.half_turn - second.half_turn;
  const double defects = first.defect + second.defect;
  const double turned_by = 2.09 * (half + 2 * second.defect);
  const double turned_apart = 2.28 * (square_root(dot(apart, apart)) + 2 * defects);
  const double unscaled = 1 / d.scale;
  const double lost = unscaled * square_root(largest) * (2 * second.defect + 64 * u);
  const double changed = unscaled * square_root(squared) + lost;
  const double bend = (turned_apart * first.speed + turned_by * changed) / (1 - turned_by / 2);
  way.off = (bend / 8 + lost + first.rounding + second.rounding) * (1 + 64 * u);
  return true;
}

}  // namespace detail

/// Returns the better view of a pair. `d`: its differences as they are.
template <int N>
COLLIDED_HD BentWay<N> bent_way(const Differences<double, N>& d, const PairTurn& turn) {
  const BentWay<N> as_it_is{d, turn.off()};
  BentWay<N> seen{d, 0};
  return turn.both() && detail::see_from_second(turn, seen) && seen.off < as_it_is.off ? seen : as_it_is;
}

}  // namespace collided
