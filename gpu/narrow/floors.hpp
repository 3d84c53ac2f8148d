#pragma once
// Floors: the least distances that a step may bring the features of a pair to, on the way and at the end. Each pair has
// its own. Features that start closer than the minimum separation m may stay so, and are free to part.
//
// f is the certified distance of a pair (certified_distance.hpp); noise is what the rounding of positions may change.
// - A pair keeps the distance d: the least of m, its f at the start, and the clearances of its vertices that may move.
//   A vertex's clearance is the least f of all pairs that contain it, but for features that an edge joins.
// - On the way the features stay farther apart than 7/8 d. At the end f is at least d - noise.
// - Noise must not accumulate over many steps. Below m there are levels, (45/64) m 2^-k, and no pair ends below the
//   level under its d. The factor keeps the levels away from distances that people choose.
// - Theta is 2^-34 of the scene's extent, which counts as the next power of two. No pair that starts above Theta sinks
//   below it.
//
// A pair that starts below 2^-34 of its own extent is tiny: certificates in double precision say too little about it
// (tiny_pairs.hpp). If m is less than 4 Theta, 4 Theta replaces it; floors near 0 would make all pairs tiny.

#include <cmath>

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
COLLIDED_HD DoubleOf<Real> largest_coordinate(const FeaturePoints<Real>& p) {
  Real largest = 0;
  for (int i = 0; i < 4; ++i) largest = max(largest, max(largest_component(p.start[i]), largest_component(p.end[i])));
  return static_cast<DoubleOf<Real>>(largest);
}

/// Holds what a pair's floors depend on, in the units of the positions. Its clearance is the other part.
struct StartDistance {
  double value;               ///< f at the start
  double extent;              ///< of the pair, as CertifiedDistance has it
  double largest_coordinate;  ///< of its whole way

  /// True if certificates say too little about the pair.
  COLLIDED_HD bool is_tiny() const { return value < kTiny * extent; }
  static constexpr double kTiny = 0x1p-34;  ///< Theta, in units of an extent
};

struct PairFloors;

/// What the floors of all pairs of a step follow from.
struct FloorRules {
  static constexpr double kOfWay = 7.0 / 8;

  double min_separation = 0;  ///< m
  double scene_extent = 0;    ///< a power of two, or 0 where all vertices are in one place

  /// `extent`: the greatest of the scene's bounds at the start. What follows from it then stays the same over many
  /// steps.
  static FloorRules of(double min_separation, double extent) {
    return {min_separation, extent > 0 ? std::exp2(std::ceil(std::log2(extent))) : 0};
  }
  bool operator==(const FloorRules&) const = default;

  /// Returns the floor that no pair sinks under that starts above it.
  COLLIDED_HD double least_floor() const { return StartDistance::kTiny * scene_extent; }
  /// Returns the distance within which pairs matter: the highest floor.
  COLLIDED_HD double reach() const { return max(min_separation, 4 * least_floor()); }

  /// `clearance`: the least clearance of the vertices that may move.
  template <class Real>
  COLLIDED_HD PairFloors floors_of(const StartDistance& start, double clearance) const;

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

/// Measures a pair at the start of its way. `way`: to where it is to go. A glance in float is enough for pairs that
/// start above all floors; of these it is only told that they do.
template <class Kind, class Real>
COLLIDED_HD StartDistance start_distance(const FeaturePoints<Real>& way, const FloorRules& rules) {
  const double largest = largest_coordinate(way), above = rules.reach() + PositionNoise<Real>::kOfFloor * largest;
  DifferencesOf<float, Kind> d;
  if (load_differences<Kind, float>(way, d)) {
    const Direction<float> direction = direction_of(gap_at(d, 0.0f).vector);
    const float offset = offset_along(direction, scaled_thickness<float>(above, d.scale));
    bool is_above = direction.length > 0;
    for (const Vec3<float>& difference : d.start)
      is_above = is_above && lower_bound_along(direction.n, difference, offset) > 0;
    if (is_above) return {above, 0, largest};
  }
  const CertifiedDistance start = certified_distance<Kind>(way.start);
  return {start.value, start.extent, largest};
}

/// The distances of a pair for one step, in the units of the positions.
struct PairFloors {
  double kept;   ///< d
  double way;    ///< the pair stays farther apart than this between start and end
  double end;    ///< what f is at the end, at least
  double noise;  ///< what rounding of positions explains
  bool is_tiny;  ///< the floors say nothing of such a pair

  /// Returns the distance that straight lines keep for ways that bend a little: it leaves room below it.
  COLLIDED_HD double bent_way() const { return way + kept / 32; }
};

template <class Real>
COLLIDED_HD PairFloors FloorRules::floors_of(const StartDistance& start, double clearance) const {
  const double f = start.value, m = min_separation;
  PairFloors floors;
  floors.kept = min(min(reach(), f), max(clearance, 4 * least_floor()));
  floors.way = kOfWay * floors.kept;
  floors.noise = PositionNoise<Real>::kOfFloor * start.largest_coordinate;
  const double least = floors.kept >= least_floor() ? least_floor() : 0;
  floors.end = max(max(floors.kept - floors.noise, hold_of(floors.kept)), max(least, floors.way));
  if (floors.kept == m && f >= m + floors.noise) floors.end = m;
  floors.is_tiny = start.is_tiny();
  return floors;
}

}  // namespace collided
