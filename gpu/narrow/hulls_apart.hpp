#pragma once
// Pairs that stay apart whatever fractions their vertices take. Every vertex ends between its start x and its target p,
// at a fraction of its own. The test looks for a plane that separates all x and p of one feature from all x and p of
// the other. The gap must be the distance asked for, and what rounding or a turn may move a vertex off its straight
// way. Then the features stay apart at every fraction, at the end of the step and on the way. A glance in float, along
// one direction, is enough: of what it leaves, a closer look in double tells one in ten apart and costs more than these
// pairs do later.

#include "gpu/base/half_thickness.hpp"
#include "gpu/contacts/contact.hpp"
#include "gpu/exec/atomic.hpp"
#include "gpu/narrow/floors.hpp"

namespace collided {

/// True if the features stay farther apart than `distance` for certain, and end so, however far each of their vertices
/// goes from p.start towards p.end. False says nothing. `d`: their differences. Work is float, and Real what positions
/// have; or four of either.
template <class Kind, class Work, class Real>
COLLIDED_HD Mask<Work> hulls_are_apart(const DifferencesOf<Work, Kind>& d, const FeaturePoints<Real>& p,
                                       const DoubleOf<Real>& distance) {
  using Difference = DifferenceOf<Kind>;
  using Wide = DoubleOf<Real>;
  const Direction<Work> direction = direction_of(gap_at(d, Work(0.5f)).vector);
  const Wide off = PositionNoise<Real>::kOfBlend * largest_coordinate(p);
  const Work offset = offset_along(direction, scaled_thickness<Work>(distance + 4 * off, d.scale));
  Work approach[4];  // how far each vertex can come nearer along the direction, at most
  for (int i = 0; i < 4; ++i) {
    const Vec3<Wide> way = convert<Wide>(p.end[i]) - convert<Wide>(p.start[i]);
    const Vec3<Work> n = i < Difference::kOfFirst ? direction.n : Work(-1) * direction.n;
    approach[i] = max(Work(0) - lower_bound_along(n, convert<Work>(d.scale * way), Work(0)), Work(0));
  }
  Mask<Work> is_apart = direction.length > 0;
  for (int k = 0; k < Difference::kCount; ++k) {
    const Work most = approach[Difference::minuend(k)] + approach[Difference::subtrahend(k)];
    is_apart = is_apart && lower_bound_along(direction.n, d.start[k], offset) > most * (1 + 4 * Precision<Work>::kUnit);
  }
  return is_apart;
}

template <class Kind, class Real>
COLLIDED_HD bool hulls_are_apart(const FeaturePoints<Real>& p, double distance) {
  DifferencesOf<float, Kind> d;
  return load_differences<Kind, float>(p, d) && hulls_are_apart<Kind>(d, p, distance);
}

/// The distance of hulls, of pairs that no fractions are to bring within `reach`. `largest`: coordinate of the pair.
template <class Real>
COLLIDED_HD DoubleOf<Real> hulls_distance(const DoubleOf<Real>& reach, const DoubleOf<Real>& largest) {
  return reach + PositionNoise<Real>::kOfFloor * largest;
}

/// Keeps the candidates of one kind that some fractions could bring too near. Contacts are among them.
template <class Real, class Kind>
struct ScreenHulls {
  const Vec3<Real>* start;
  const Vec3<Real>* target;
  Kind kind;
  double ways_within;      ///< pairs matter within this distance at any fraction
  double contacts_within;  ///< what the positions of their features say, in a scene without thick meshes
  Deviations deviations;
  Span<const uint64_t> candidates;
  AppendList<uint64_t> survivors;
  HalfThicknesses halves = {};

  COLLIDED_HD void operator()(uint64_t i) const {
    const Stencil s = kind.stencil(candidates[i]);
    const FeaturePoints<Real> p = points_of(s, start, target);
    if (!hulls_are_apart<Kind>(p, hulls_distance<Real>(reach(s), largest_coordinate(p)))) survivors.push(candidates[i]);
  }

  COLLIDED_HD double reach(const Stencil& s) const {
    const double within = halves.of_pair(contacts_within, s.v[0], s.v[3]).above();
    if (!deviations.is_needed()) return max(ways_within, within);
    return max(Deviations::widened(ways_within, deviations.of_parts().of_pair(s.v[0], s.v[3])),
               Deviations::widened(within, deviations.of_any_pair()));
  }
};

}  // namespace collided
