#pragma once
// A step in which each vertex goes as far as it can. A vertex ends at y = blend(x, p, a); a is a fraction of its own,
// or of its group. The vertices of a rigid mesh are one group, whose pose ends at pose_along(). All fractions begin at
// 1 and shrink in rounds. A round looks at the pairs whose vertices changed. A pair passes if its way from x to the
// rounded y keeps its floors (floors.hpp). Ways are straight but for meshes that turn (bent_ways.hpp). A pair that
// fails proposes a share for each of its vertices. A vertex takes the least share that is proposed to it, and its
// fraction is multiplied by it.
//
// The result does not depend on the order of the pairs: a proposal follows from x, y and the floors of one pair, and a
// minimum has no order. Later rounds propose less, so that the rounds end. The first propose times of impact. Then both
// sides stop at a plane, then failed pairs stand still, and at last all that is connected to them stands still. A pair
// that has passed is looked at again when a fraction of its vertices changes.

#include "gpu/narrow/bent_ways.hpp"
#include "gpu/narrow/floors.hpp"
#include "gpu/narrow/tiny_pairs.hpp"

namespace collided {

/// A share or a fraction of 1 as an integer. Those in [0, 1] have the order of their bits.
constexpr uint64_t kWholeBits = 0x3ff0000000000000;

/// How failed pairs shorten their vertices' ways, by the round.
enum class Shortening { kTimes, kPlanes, kStand, kIslands };

COLLIDED_HD inline Shortening shortening_of(uint32_t round) {
  constexpr uint32_t kPlanesFrom = 12, kStandFrom = 24, kIslandsFrom = 96;
  if (round < kPlanesFrom) return Shortening::kTimes;
  if (round < kStandFrom) return Shortening::kPlanes;
  return round < kIslandsFrom ? Shortening::kStand : Shortening::kIslands;
}

/// Returns a vertex's or group's fraction after the least of the shares proposed to it. Ways that round to nothing end
/// the rounds sooner.
COLLIDED_HD inline double shortened(double fraction, double share) {
  constexpr double kLeast = 0x1p-44;
  const double next = fraction * share;
  return next < kLeast ? 0 : next;
}

/// Returns the differences of features that stand still as they are at t.
template <int N>
COLLIDED_HD Differences<double, N> standing_at(const Differences<double, N>& d, double t) {
  Differences<double, N> still;
  still.extent = 0, still.scale = d.scale;
  for (int k = 0; k < N; ++k) {
    still.start[k] = still.end[k] = d.at(k, t);
    still.extent = max(still.extent, largest_component(still.start[k]));
  }
  return still;
}

template <class Real>
COLLIDED_HD bool is_same(const Vec3<Real>& a, const Vec3<Real>& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}
template <class Real>
COLLIDED_HD bool stands_still(const FeaturePoints<Real>& way) {
  for (int i = 0; i < 4; ++i)
    if (!is_same(way.start[i], way.end[i])) return false;
  return true;
}

/// Tries keeps_floors() at a glance, in float and along one direction. That is enough for most pairs. The way may be
/// off its straight line by `off`.
template <class Kind, class Real>
COLLIDED_HD bool keeps_floors_at_a_glance(const FeaturePoints<Real>& way, const PairFloors& floors, double off) {
  DifferencesOf<float, Kind> d;
  if (!load_differences<Kind, float>(way, d)) return false;
  const Direction<float> direction = direction_of(gap_at(d, 0.5f).vector);
  const float on_the_way =
      offset_along(direction, scaled_thickness<float>(Deviations::widened(floors.way, off), d.scale));
  const float at_end = offset_along(direction, scaled_thickness<float>(floors.end, d.scale));
  bool is_above = direction.length > 0;
  for (int k = 0; k < DifferenceOf<Kind>::kCount; ++k)
    is_above = is_above && lower_bound_along(direction.n, d.start[k], on_the_way) > 0 &&
               lower_bound_along(direction.n, d.end[k], at_end) > 0;
  return is_above;
}

/// True if a pair keeps its floors on the way from x to y, for certain. The way is straight but for meshes that turn.
template <class Kind, class Real>
COLLIDED_LONG COLLIDED_HD bool keeps_floors(const FeaturePoints<Real>& way, const PairFloors& floors,
                                            const PairTurn& turn = {}) {
  if (turn.is_straight() && stands_still(way)) return true;
  if (floors.is_tiny) {
    if (!turn.is_straight()) return false;
    const CertifiedDistance start = certified_distance<Kind>(way.start);
    return start.value > 0 && comes_no_nearer_along<Kind>(start.along.n, way);
  }
  const double off = turn.is_straight() ? 0 : detail::off_straight(turn, detail::Chords::of<Kind>(way));
  if (keeps_floors_at_a_glance<Kind>(way, floors, off)) return true;
  if (!(certified_distance<Kind>(way.end).value >= floors.end)) return false;
  DifferencesOf<double, Kind> d;
  if (!load_differences<Kind, double>(way, d)) return false;
  const auto bent = bent_way<Kind>(way, d, turn);
  return certified_way(bent.d, Deviations::widened(floors.way, bent.off)).is_free;
}

/// The shares of its vertices' ways that a failed pair proposes, each from 0 to 1. At least one vertex that moves gets
/// less than 1.
struct Shares {
  double of[4];

  COLLIDED_HD static Shares all(double share) { return {{share, share, share, share}}; }
};

namespace detail {

/// How far each vertex goes towards the other feature along n, which points to the first feature's side.
template <class Kind, class Real>
COLLIDED_HD void approaches_along(const Vec3<double>& n, const FeaturePoints<Real>& way, double (&towards)[4]) {
  for (int i = 0; i < 4; ++i) {
    const double along = dot(n, convert<double>(way.end[i]) - convert<double>(way.start[i]));
    towards[i] = i < DifferenceOf<Kind>::kOfFirst ? -along : along;
  }
}

/// Leaves meshes that turn no more than `share`.
template <class Kind>
COLLIDED_HD void shorten_turns(const PairTurn& turn, double share, Shares& shares) {
  for (int i = 0; i < 4; ++i)
    if ((i < DifferenceOf<Kind>::kOfFirst ? turn.first : turn.second) != nullptr)
      shares.of[i] = min(shares.of[i], share);
}

/// Returns the share of a pair's turns with which its way may be free. A part of a turn is off its straight line by
/// about the square of the share. Meshes that turn by too much to be seen from each other turn by less first.
template <int N>
COLLIDED_HD double share_of_turns(const BentWay<N>& bent, const PairFloors& floors, const PairTurn& turn,
                                  const Group& team) {
  constexpr int kHalves = 12;
  if (turn.both())
    if (const double most = greater_sine_of_half(turn); !(most < kMostSineOfHalf)) return 0.5 * kMostSineOfHalf / most;
  double best = 0, share = 1, off = bent.off;
  for (int i = 0; i <= kHalves && best < share; ++i, share /= 2, off /= 4)
    best = max(best, min(share, certified_way(bent.d, Deviations::widened(floors.bent_way(), off), team).until));
  return best;
}

/// Vertices that approach stop a little before the features come as near as they may.
template <class Kind, class Real>
COLLIDED_HD Shares shares_by_time(const FeaturePoints<Real>& way, const PairFloors& floors, const PairTurn& turn,
                                  const Group& team) {
  constexpr double kKept = 1 - 0x1p-7;
  DifferencesOf<double, Kind> d;
  if (!load_differences<Kind, double>(way, d)) return Shares::all(0);
  const auto bent = bent_way<Kind>(way, d, turn);
  const bool only_bends = bent.off > 0 && certified_distance<Kind>(way.end, team).value >= floors.end;
  const double until = min(certified_way(bent.d, only_bends ? floors.bent_way() : floors.kept, team).until, 1.0);
  Shares shares = Shares::all(1);
  if (!only_bends || until < 1) {
    Direction<double> direction = certified_distance(standing_at(d, until), team).along;
    if (!(direction.length > 0)) direction = certified_distance<Kind>(way.start, team).along;
    double towards[4];
    approaches_along<Kind>(direction.n, way, towards);
    const bool any_approaches = towards[0] > 0 || towards[1] > 0 || towards[2] > 0 || towards[3] > 0;
    for (int i = 0; i < 4; ++i)
      if (towards[i] > 0 || !any_approaches) shares.of[i] = kKept * until;
  }
  if (only_bends) shorten_turns<Kind>(turn, kKept * share_of_turns(bent, floors, turn, team), shares);
  return shares;
}

/// Both features stop at planes across the direction at the start, which share the room between them by how far each
/// goes.
template <class Kind, class Real>
COLLIDED_HD Shares shares_by_planes(const FeaturePoints<Real>& way, const PairFloors& floors, const PairTurn& turn,
                                    const Group& team) {
  constexpr double kOfRoom = 0.9, kLess = 1 - 0x1p-20;
  const CertifiedDistance start = certified_distance<Kind>(way.start, team);
  if (!(start.along.length > 0)) return Shares::all(0);
  double towards[4], most[2] = {0, 0};
  approaches_along<Kind>((1 / start.along.length) * start.along.n, way, towards);
  for (int i = 0; i < 4; ++i) {
    double& of_feature = most[i < DifferenceOf<Kind>::kOfFirst ? 0 : 1];
    of_feature = max(of_feature, towards[i]);
  }
  // What the floor leaves, less than rounding takes: of y, and of its distance.
  const double room = kOfRoom * max(start.value - floors.end - 0.75 * floors.noise, 0.0);
  Shares shares = Shares::all(1);
  for (int i = 0; i < 4; ++i) {
    const double own =
        most[0] + most[1] > 0 ? room * (most[i < DifferenceOf<Kind>::kOfFirst ? 0 : 1] / (most[0] + most[1])) : 0;
    if (towards[i] > own) shares.of[i] = own / towards[i] * kLess;
  }
  DifferencesOf<double, Kind> d;
  if (!turn.is_straight() && load_differences<Kind, double>(way, d))
    shorten_turns<Kind>(turn, share_of_turns(bent_way<Kind>(way, d, turn), floors, turn, team), shares);
  const bool any_shortened = shares.of[0] < 1 || shares.of[1] < 1 || shares.of[2] < 1 || shares.of[3] < 1;
  return any_shortened ? shares : Shares::all(0);
}

}  // namespace detail

/// Returns what a pair proposes that does not keep its floors on the way from x to y. All threads of a team call, and
/// get the same.
template <class Kind, class Real>
COLLIDED_LONG COLLIDED_HD Shares shares_of_failed(const FeaturePoints<Real>& way, const PairFloors& floors,
                                                  Shortening how, const PairTurn& turn = {},
                                                  const Group& team = Group{0, 1}) {
  if (floors.is_tiny) return Shares::all(0);
  if (how == Shortening::kTimes) return detail::shares_by_time<Kind>(way, floors, turn, team);
  if (how == Shortening::kPlanes) return detail::shares_by_planes<Kind>(way, floors, turn, team);
  return Shares::all(0);
}

}  // namespace collided
