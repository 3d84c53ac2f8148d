#pragma once
// What one step finds out about itself while it runs: the grid, the lengths of all lists, and what is reported of it.
// It lives on the backend and is read once, when the step is over.

#include "gpu/base/deviations.hpp"
#include "gpu/contacts/kinds.hpp"
#include "gpu/engines/octree/levels.hpp"
#include "gpu/engines/octree/subdivision.hpp"
#include "gpu/narrow/coplanarity_filter.hpp"
#include "gpu/search/neighbours.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Bounds the ways of all vertices in a frame that advances.
struct WaysMeasure {
  Box<float> start;  ///< around the vertices at t = 0, rounded outward
  float longest;     ///< coordinate of a way, rounded up
};

/// Counts the rounds that shorten ways, and the pairs of the last one (narrow/shortening.hpp).
struct RoundCounts {
  uint64_t failed[kFeatureKinds];
  uint64_t joined;   ///< vertices that an island took in, at the last look
  uint64_t number;   ///< of the round in work: rounds that are over
  uint64_t goes_on;  ///< 1: another round follows that needs nothing of the host

  COLLIDED_HD uint64_t count_failed() const { return failed[0] + failed[1]; }
};

/// A vertex that goes less than its whole way.
struct ShortenedWay {
  double fraction;
  uint64_t vertex;
};

/// Sums of all vertices' ways.
struct WaysGone {
  uint64_t all, gone;   ///< lengths, in a unit that GoneOfWays has
  uint64_t least_bits;  ///< the least fraction of what moves, as an integer
};

struct StepState {
  // Lengths that were asked for, whatever the lists' capacities.
  LeafTotals leaves;
  uint64_t large, bricks[kMaxRounds], brick_items[kMaxRounds];
  uint64_t pairs, candidates[kFeatureKinds], kept[kFeatureKinds], screened[kFeatureKinds], resumable[kFeatureKinds];
  uint64_t near_misses[kFeatureKinds];  ///< pairs that a contact's time is sought for once more
  uint64_t triangle_pairs, crossing_pairs, edge_tests, contacts, earliest, crowded_ranks;
  KindBegins kinds;  ///< in the sorted list

  uint64_t neighbours[kFeatureKinds];  ///< that the step listed
  Displacement displacement;           ///< of steps with lists of neighbours

  uint64_t exact_decisions, undecided;   ///< at kExact; those that are left to the host
  uint64_t decided_last[kFeatureKinds];  ///< contacts that are not simple
  uint64_t open_features;                ///< of contacts, that the host has to tell

  uint64_t next_item[kContactKinds];      ///< of the searches for pairs, by the first kind that each is for
  uint64_t next_query[kFeatureKinds][2];  ///< of the narrow phase, in float and in double
  uint64_t next_decision[kFeatureKinds];
  uint64_t small_triangles;
  Box<float> bounds;
  LevelTotals totals;
  uint64_t extents;  ///< of all triangles, for engines that need their mean
  OrdinaryExtents ordinary;
  GridState grid;
  FilterScale filter;
  Shortcut shortcut;
  double earliest_toi;  ///< of contacts that stay on the backend

  WaysMeasure ways;                  ///< of frames that advance
  uint64_t blocking[kFeatureKinds];  ///< candidates that ways may have to be shortened for
  uint64_t filtered[kFeatureKinds];  ///< those of them that the filter keeps
  RoundCounts round;
  WaysGone gone;
  uint64_t shortened;  ///< listed vertices
};

/// That the step asked for.
inline ListLengths lengths_of(const StepState& state) {
  ListLengths lengths;
  for (const uint64_t n : state.bricks) lengths[ListLengths::kBricks] += n;
  for (const uint64_t n : state.brick_items) lengths[ListLengths::kBrickItems] += n;
  lengths[ListLengths::kLarge] = state.large;
  lengths[ListLengths::kLeaves] = state.leaves[LeafSum::kLeaves];
  lengths[ListLengths::kRegistrations] = state.leaves[LeafSum::kRegistrations];
  lengths[ListLengths::kPairItems] = state.leaves[LeafSum::kItems];
  lengths[ListLengths::kTrianglePairs] = max(state.triangle_pairs, state.crossing_pairs);
  lengths[ListLengths::kContacts] = state.contacts;
  lengths[ListLengths::kEarliest] = state.earliest;
  for (int kind = 0; kind < kFeatureKinds; ++kind) {
    lengths[ListLengths::kKept + kind] = state.kept[kind];
    lengths[ListLengths::kScreened + kind] = state.screened[kind];
    lengths[ListLengths::kResumable + kind] = state.resumable[kind];
  }
  return lengths;
}

/// Set up before the narrow phase: what depends on the scene's bounds.
struct PrepareNarrow {
  StepState* state;
  double thickness;
  Deviations deviations = {};  ///< the filter treats all pairs as the one that is farthest off

  COLLIDED_HD void operator()(uint64_t) const {
    state->filter = filter_within(state->bounds, Deviations::widened(thickness, deviations.of_any_pair()));
    state->shortcut = {detail::bit_copy<uint64_t>(1.0), 0};
  }
};

/// The same for a step that looks at displacements instead.
struct PrepareDisplaced {
  PrepareNarrow narrow;

  COLLIDED_HD void operator()(uint64_t i) const {
    narrow.state->bounds = narrow.state->displacement.bounds;
    narrow(i);
  }
};

/// All that is decided for a step from the bounds and the counts of its triangles.
struct PrepareStep {
  ChooseGrid grid;
  PrepareNarrow narrow;

  COLLIDED_HD void operator()(uint64_t i) const {
    grid(i);
    narrow(i);
  }
};

}  // namespace collided
