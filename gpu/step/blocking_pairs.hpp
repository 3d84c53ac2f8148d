#pragma once
// Functors of a step that advances: what it does with each pair of features, and with each vertex
// (narrow/shortening.hpp).

#include "gpu/base/groups.hpp"
#include "gpu/exact/fixed/decide.hpp"
#include "gpu/exact/fixed/parting.hpp"
#include "gpu/narrow/gather.hpp"
#include "gpu/narrow/limits.hpp"
#include "gpu/narrow/shortening.hpp"
#include "gpu/search/excluded_pairs.hpp"
#include "gpu/state/level_needs.hpp"
#include "gpu/state/state.hpp"

namespace collided {

/// The vertices of a pair and all that an edge joins to them, on their ways (exact/fixed/parting.hpp).
template <class Kind, class Real>
struct PairStars {
  static constexpr int kFirst = DifferenceOf<Kind>::kOfFirst;
  static constexpr int kMostEdges = 12;            ///< of a vertex, in looking for directions
  static constexpr uint32_t kMostNeighbours = 64;  ///< of a vertex

  Stencil s;
  VertexRings joined;
  const Vec3<Real>* start;
  const Vec3<Real>* end;

  /// Whether they are few enough to be looked at.
  COLLIDED_HD bool are_small() const {
    for (const uint32_t v : s.v)
      if (joined.size(v) > kMostNeighbours) return false;
    return true;
  }
  template <class Use>
  COLLIDED_HD void own(int i, const Use& use) const {
    use(convert<double>(start[s.v[i]]), convert<double>(end[s.v[i]]));
  }
  template <class Use>
  COLLIDED_HD void neighbours(int i, const Use& use) const {
    joined.for_each(s.v[i], [&](uint32_t v) { use(convert<double>(start[v]), convert<double>(end[v])); });
  }
  /// What is joined to both ends of an edge is a corner of its triangles, or leaves the edge less room.
  template <class Use>
  COLLIDED_HD void around(int feature, const Use& use) const {
    if (kFirst == 1) {
      if (feature == 0) neighbours(0, use);
      return;
    }
    const uint32_t a = s.v[2 * feature], b = s.v[2 * feature + 1];
    joined.for_each(a, [&](uint32_t v) {
      if (joined.connect(v, b)) use(convert<double>(start[v]), convert<double>(end[v]));
    });
  }
};

/// True if a pair may go the way from x to y, for certain. A tiny pair whose way is straight may also move as one. It
/// may come nearer if integers decide that it does not touch, or touch at the start and part.
template <class Kind, class Real>
COLLIDED_LONG COLLIDED_HD bool is_way_free(const PairStars<Kind, Real>& stars, const PairFloors& floors,
                                           const PairTurn& turn = {}) {
  const FeaturePoints<Real> way = points_of(stars.s, stars.start, stars.end);
  if (keeps_floors<Kind>(way, floors, turn)) return true;
  if (!floors.is_tiny || !turn.is_straight()) return false;
  if (moves_as_one(way)) return true;
  Vec3<double> from[4], to[4];
  for (int k = 0; k < 4; ++k) from[k] = convert<double>(way.start[k]), to[k] = convert<double>(way.end[k]);
  if (exact::fixed::decide<Kind::kKind>(from, to).outcome == exact::fixed::Outcome::kApart) return true;
  return stars.are_small() && exact::fixed::part<Kind::kKind>(stars);
}

/// Pairs of one kind on the backend, and what is known of them. Each vertex that may move has a clearance and belongs
/// to a group, which has a fraction.
template <class Real, class Kind>
struct WaysOfPairs {
  const Vec3<Real>* start;
  const Vec3<Real>* end;  ///< as far as the vertices go
  Kind kind;
  FloorRules rules;
  Span<const uint64_t> pairs;
  Span<StartDistance> starts;
  VertexRings joined;  ///< by one edge
  const uint32_t* group_of;
  uint64_t* clearances;
  MeshTurns turns;

  COLLIDED_HD Stencil stencil(uint64_t pair) const { return kind.stencil(pairs[pair]); }
  COLLIDED_HD FeaturePoints<Real> way(const Stencil& s) const { return points_of(s, start, end); }
  COLLIDED_HD PairStars<Kind, Real> stars(const Stencil& s) const { return {s, joined, start, end}; }
  COLLIDED_HD PairTurn turn(const Stencil& s) const { return {turns.of(s.v[0]), turns.of(s.v[3])}; }
  COLLIDED_HD PairFloors floors(uint64_t pair, const Stencil& s) const {
    uint64_t least = detail::bit_copy<uint64_t>(HUGE_VAL);
    for (const uint32_t v : s.v)
      if (group_of[v] != kStands) least = min(least, clearances[v]);
    return rules.floors_of<Real>(starts[pair], detail::bit_copy<double>(least));
  }
};

/// Measures the distance that each pair starts at, and so the clearances.
template <class Real, class Kind>
struct MeasureStarts {
  WaysOfPairs<Real, Kind> ways;

  COLLIDED_HD void operator()(uint64_t pair) const {
    const Stencil s = ways.stencil(pair);
    const StartDistance start = start_distance<Kind>(ways.way(s), ways.rules);
    ways.starts[pair] = start;
    if (start.value >= ways.rules.reach() || are_joined(s)) return;
    for (const uint32_t v : s.v)
      if (ways.group_of[v] != kStands) atomic_min(ways.clearances[v], detail::bit_copy<uint64_t>(start.value));
  }

 private:
  COLLIDED_HD bool are_joined(const Stencil& s) const {
    constexpr int kFirst = DifferenceOf<Kind>::kOfFirst;
    for (int i = 0; i < kFirst; ++i)
      for (int j = kFirst; j < 4; ++j)
        if (ways.joined.connect(s.v[i], s.v[j])) return true;
    return false;
  }
};

/// Lists the pairs that may not go their ways: of all, or of those that the round in work has changed. It has changed a
/// pair with a vertex whose fraction it has changed, and a tiny one that is joined to such a vertex.
template <class Real, class Kind>
struct JudgePairs {
  WaysOfPairs<Real, Kind> ways;
  const uint32_t* changed_in;
  const uint64_t* round;  ///< its number; null: all pairs are judged
  AppendList<uint64_t> failed;

  COLLIDED_HD void operator()(uint64_t pair) const {
    const Stencil s = ways.stencil(pair);
    if (round != nullptr && !has_changed(pair, s)) return;
    if (!is_way_free(ways.stars(s), ways.floors(pair, s), ways.turn(s))) failed.push(pair);
  }

 private:
  COLLIDED_HD bool has_changed(uint64_t pair, const Stencil& s) const {
    const bool is_tiny = ways.starts[pair].is_tiny();
    bool any = false;
    for (const uint32_t v : s.v) {
      any = any || has_changed(v);
      if (is_tiny) ways.joined.for_each(v, [&](uint32_t w) { any = any || has_changed(w); });
    }
    return any;
  }
  COLLIDED_HD bool has_changed(uint32_t v) const {
    const uint32_t group = ways.group_of[v];
    return group != kStands && changed_in[group] == *round + 1;
  }
};

/// Pairs that limit the ways, as contacts of a list that has room for all of them.
struct LimitList {
  Span<uint64_t> keys;  ///< with the ranks of first features
  Span<ContactData<double>> data;
  Span<Normal> normals;
};

/// Writes the failed pairs of a kind to a list of limits, from place `first` on. All vertices go all of their ways.
template <class Real, class Kind>
struct MeasureLimits {
  WaysOfPairs<Real, Kind> ways;
  Span<const uint64_t> failed;
  uint32_t first_rank;  ///< of the kind's first features
  uint64_t first;
  LimitList limits;

  COLLIDED_HD void operator()(uint64_t i) const {
    const uint64_t pair = failed[i], place = first + i;
    const Stencil s = ways.stencil(pair);
    const FeaturePoints<Real> way = ways.way(s);
    const ContactData<double> limit = limit_of<Kind>(way, ways.floors(pair, s), ways.turn(s));
    limits.keys[place] = ways.pairs[pair] + (uint64_t{first_rank} << 32);
    limits.data[place] = limit;
    limits.normals[place] = contact_normal<Kind>(way, limit.toi, kClear);
  }
};

/// Leaves the least share that any failed pair proposes to a group. A GPU's warp works on one pair as long as there are
/// few, else each of its threads on one.
template <class Real, class Kind>
struct ProposeShares {
  using Shared = Nothing;
  static constexpr uint32_t kGroupSize = 32, kGroupsOfProcessor = 32;
  WaysOfPairs<Real, Kind> ways;
  Span<const uint64_t> failed;
  Counted count;
  const uint64_t* round;  ///< its number
  uint64_t* shares;

  COLLIDED_HD void operator()(uint64_t i, const Group& group, Nothing&) const {
    share_few(i, group, count.size(), [&](uint64_t k, const Group& team) { propose(failed[k], team); });
  }

 private:
  COLLIDED_HD void propose(uint64_t pair, const Group& team) const {
    const Stencil s = ways.stencil(pair);
    const Shortening how = shortening_of(static_cast<uint32_t>(*round));
    const Shares proposed = shares_of_failed<Kind>(ways.way(s), ways.floors(pair, s), how, ways.turn(s), team);
    for (int k = 0; k < 4 && team.rank == 0; ++k)
      if (const uint32_t group = ways.group_of[s.v[k]]; group != kStands && proposed.of[k] < 1)
        atomic_min(shares[group], detail::bit_copy<uint64_t>(proposed.of[k]));
  }
};

/// Spreads shares of 0 through pairs, to all of their vertices that move. Counts the vertices that it reaches.
template <class Real, class Kind>
struct JoinIslands {
  WaysOfPairs<Real, Kind> ways;  ///< to where the vertices are to go
  uint64_t* shares;
  uint64_t* joined;

  COLLIDED_HD void operator()(uint64_t pair) const {
    const Stencil s = ways.stencil(pair);
    bool stands = false;
    for (const uint32_t v : s.v) stands = stands || (moves(v) && atomic_read(shares[ways.group_of[v]]) == 0);
    if (!stands) return;
    for (const uint32_t v : s.v)
      if (moves(v) && atomic_read(shares[ways.group_of[v]]) != 0) {
        atomic_write(shares[ways.group_of[v]], uint64_t{0});
        atomic_add(*joined, uint64_t{1});
      }
  }

 private:
  COLLIDED_HD bool moves(uint32_t v) const {
    return ways.group_of[v] != kStands && !is_same(ways.start[v], ways.end[v]);
  }
};

/// Shortens groups by the shares of a round, and makes the shares those of the next one, which proposes none yet. No
/// pair has failed in that one so far.
struct TakeShares {
  uint64_t* shares;
  double* fractions;
  uint32_t* changed_in;
  RoundCounts* round;

  COLLIDED_HD void operator()(uint64_t group) const {
    if (group == 0)
      for (uint64_t& failed : round->failed) failed = 0;
    const uint64_t share = shares[group];
    if (share == kWholeBits) return;
    shares[group] = kWholeBits;
    const double next = shortened(fractions[group], detail::bit_copy<double>(share));
    if (next == fractions[group]) return;
    fractions[group] = next;
    changed_in[group] = static_cast<uint32_t>(round->number) + 1;
  }
};

/// The round is over. Islands need the host.
struct EndRound {
  RoundCounts* round;

  COLLIDED_HD void operator()(uint64_t) const {
    ++round->number;
    round->goes_on = round->count_failed() > 0 && shortening_of(round->number) != Shortening::kIslands ? 1 : 0;
  }
};

/// Sets up a vertex, or the group of its number, before the first round.
struct BeginWays {
  uint64_t* clearances;
  uint64_t* shares;
  double* fractions;
  uint32_t* changed_in;

  COLLIDED_HD void operator()(uint64_t v) const {
    clearances[v] = detail::bit_copy<uint64_t>(HUGE_VAL);
    shares[v] = kWholeBits;
    fractions[v] = 1;
    changed_in[v] = 0;
  }
};

/// Returns how far a vertex goes. Lengths are counted in whole units, so that the order of a sum plays no part.
template <class Real>
struct GoneOfWay {
  const Vec3<Real>* start;
  const Vec3<Real>* target;
  const uint32_t* group_of;
  const double* fractions;
  const WaysMeasure* ways;
  uint64_t vertices;

  COLLIDED_HD WaysGone operator()(uint64_t v) const {
    const uint32_t group = group_of[v];
    if (group == kStands || is_same(start[v], target[v])) return nothing();
    const Vec3<double> way = units_of_length() * (convert<double>(target[v]) - convert<double>(start[v]));
    const double length = square_root(dot(way, way)), a = fractions[group];
    return {static_cast<uint64_t>(length), static_cast<uint64_t>(a * length), detail::bit_copy<uint64_t>(a)};
  }
  COLLIDED_HD static WaysGone nothing() { return {0, 0, kWholeBits}; }

 private:
  /// A power of two, with which no sum reaches 2^64.
  COLLIDED_HD double units_of_length() const {
    constexpr uint64_t kExponent = 0x7ff0000000000000;
    const double most = 0x1p63 / (static_cast<double>(vertices) * ways->longest);
    return detail::bit_copy<double>(detail::bit_copy<uint64_t>(most) & kExponent);
  }
};
struct AddGone {
  COLLIDED_HD WaysGone operator()(const WaysGone& a, const WaysGone& b) const {
    return {a.all + b.all, a.gone + b.gone, min(a.least_bits, b.least_bits)};
  }
};

/// Marks the groups with a vertex that moves, by a share of 0; none if another round follows, which begins with shares.
template <class Real>
struct MarkMoving {
  const RoundCounts* round;
  const Vec3<Real>* start;
  const Vec3<Real>* target;
  const uint32_t* group_of;
  uint64_t* shares;

  COLLIDED_HD void operator()(uint64_t v) const {
    const uint32_t group = group_of[v];
    if (round->count_failed() > 0 || group == kStands || is_same(start[v], target[v])) return;
    atomic_write(shares[group], uint64_t{0});
  }
};

/// Lists the vertices of marked groups that go less than their whole ways, or the first of each such group.
struct ListShortened {
  const uint32_t* group_of;
  const double* fractions;
  const uint64_t* shares;
  bool first_of_group;
  AppendList<ShortenedWay> shortened;

  COLLIDED_HD void operator()(uint64_t v) const {
    const uint32_t group = group_of[v];
    if (group == kStands || (first_of_group && group != v)) return;
    if (shares[group] == 0 && fractions[group] < 1) shortened.push({fractions[group], v});
  }
};

/// Measures the way of one vertex.
template <class Real>
struct MeasureWay {
  const Vec3<Real>* start;
  const Vec3<Real>* end;

  COLLIDED_HD WaysMeasure operator()(uint64_t v) const {
    const Vec3<double> x = convert<double>(start[v]), p = convert<double>(end[v]);
    return {outward_float(Path<Real>{start[v], start[v]}.swept()), round_up<float>(largest_component(p - x))};
  }
};
struct JoinMeasures {
  COLLIDED_HD WaysMeasure operator()(const WaysMeasure& a, const WaysMeasure& b) const {
    return {JoinBoxes{}(a.start, b.start), max(a.longest, b.longest)};
  }
};

}  // namespace collided
