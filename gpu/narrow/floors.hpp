#pragma once
// How near each other a step may leave two features, and how near it may bring them on the way. Every pair has floors
// of its own, so that features that start nearer than the minimum separation m stay as they are and are free to part.
// They follow from the distance f of certified_distance.hpp at the start, which the pair never falls short of but by
// what rounding of positions explains (`noise`):
// - A pair keeps d, the least of m, f, and its clearance: the least f of other pairs of its four vertices.
// - On the way it stays farther apart than 7/8 d; at the end f is at least d - noise.
// - Noise must not add up over steps: below m no pair sinks under (45/64) m 2^-k for the k that it started above. No
//   distance that people choose has these numbers, and a pair is held there at the latest.
// - No pair sinks under Theta, 2^-34 of the scene's extent, but a pair that starts there.
// Pairs that start under 2^-34 of their own extent are tiny: certificates in double tell too little of them
// (tiny_pairs.hpp). Where m is less than 4 Theta the latter replaces it, as floors near 0 would all be tiny.

#include "gpu/base/points.hpp"
#include "gpu/base/precision.hpp"
#include "gpu/narrow/certified_distance.hpp"

namespace collided {

/// What rounding of positions of a format explains, in units of the largest coordinate of a pair.
template <class Real>
struct PositionNoise;
template <>
struct PositionNoise<double> {
  static constexpr double kOfFloor = 0x1p-45;      ///< what a pair may lose in a step
  static constexpr double kOfBlend = 8 * 0x1p-53;  ///< how far off the straight way blend() is, of each coordinate
};
template <>
struct PositionNoise<float> {
  static constexpr double kOfFloor = 0x1p-21;
  static constexpr double kOfBlend = 0x1p-23;
};

/// Returns the largest coordinate of the four vertices at both ends of the step.
template <class Real>
COLLIDED_HD double largest_coordinate(const FeaturePoints<Real>& p) {
  Real largest = 0;
  for (int i = 0; i < 4; ++i) largest = max(largest, max(largest_component(p.start[i]), largest_component(p.end[i])));
  return static_cast<double>(largest);
}

struct PairFloors;

/// What the floors of all pairs of a step follow from.
struct FloorRules {
  static constexpr double kTiny = 0x1p-34;  ///< Theta, in units of the extent
  static constexpr double kOfWay = 7.0 / 8;

  double min_separation;  ///< m; may be 0
  double scene_extent;    ///< the greatest extent of the scene's bounds at the start

  /// Returns the floor that no pair sinks under that starts above it.
  COLLIDED_HD double least_floor() const { return kTiny * scene_extent; }
  /// Returns the distance within which pairs matter: the highest floor.
  COLLIDED_HD double reach() const { return max(min_separation, 4 * least_floor()); }

  /// `clearance`: the least clearance of the four vertices. `coordinate`: of largest_coordinate.
  template <class Real>
  COLLIDED_HD PairFloors floors_of(const CertifiedDistance& start, double clearance, double coordinate) const;

  /// Returns the greatest (45/64) m 2^-k that is not above `kept`; for m = 0 the greatest (45/64) 2^j.
  COLLIDED_HD double hold_of(double kept) const {
    constexpr double kShare = 45.0 / 64, kLeast = 0x1p-960, kMost = 0x1p1000;
    if (!(kept >= kLeast)) return 0;
    const double highest = kShare * (min_separation > kLeast ? min_separation : kMost);
    if (highest <= kept) return highest;
    const double hold = highest * unit_scale(highest) / unit_scale(kept);  // with the exponent of `kept`
    return hold <= kept ? hold : hold / 2;
  }
};

/// The distances of a pair for one step, in the units of the positions.
struct PairFloors {
  double kept;   ///< d
  double way;    ///< the pair stays farther apart than this between start and end
  double end;    ///< what f is at the end, at least
  double noise;  ///< what rounding of positions explains
  bool is_tiny;  ///< the floors say nothing of such a pair
};

template <class Real>
COLLIDED_HD PairFloors FloorRules::floors_of(const CertifiedDistance& start, double clearance,
                                             double coordinate) const {
  const double f = start.value, m = min_separation;
  PairFloors floors;
  floors.kept = min(min(reach(), f), max(clearance, 4 * least_floor()));
  floors.way = kOfWay * floors.kept;
  floors.noise = PositionNoise<Real>::kOfFloor * coordinate;
  floors.end =
      max(max(floors.kept - floors.noise, hold_of(floors.kept)), max(min(least_floor(), floors.kept), floors.way));
  if (floors.kept == m && f >= m + floors.noise) floors.end = m;
  floors.is_tiny = f < kTiny * start.extent;
  return floors;
}

}  // namespace collided
