#pragma once
// What becomes of the pairs of triangles that the broad phase finds.

#include "gpu/narrow/certified_proximity.hpp"
#include "gpu/narrow/coplanarity_filter.hpp"
#include "gpu/search/elementary.hpp"
#include "gpu/search/excluded_pairs.hpp"
#include "gpu/search/neighbours.hpp"
#include "gpu/state/level_needs.hpp"
#include "gpu/state/state.hpp"
#include "gpu/step/may_touch_soon.hpp"

namespace collided {

struct KeepAll {
  template <class Kind, class Real>
  COLLIDED_HD bool operator()(const Kind &, const FeaturePoints<Real> &) const {
    return true;
  }
};

/// The filter's scale in each world of a set.
struct FiltersOfWorlds {
  const FilterScale *filters = nullptr;  ///< null: the scene is one
  uint32_t triangles = 0;                ///< of a world
};

/// use(keep) with the filter of a search.
template <class Real, class Use>
void with_filter(const LevelNeeds &needs, double thickness, const StepState *state, const Use &use,
                 const FiltersOfWorlds &worlds = {}) {
  if (!needs.filters_searches())
    use(KeepAll{});
  else if (needs.is_ccd())
    use(worlds.filters == nullptr ? MaybeCoplanar<Real>{&state->filter}
                                  : MaybeCoplanar<Real>{worlds.filters, worlds.triangles});
  else
    use(NearInFloat<Real>{thickness, needs.settings.differs_by_pair()});
}

/// Returns the filter of a pair of triangles a < b, whose boxes are inflated as said.
template <class Keep, class Inflation>
COLLIDED_HD Keep filter_of(const Keep &keep, const Inflation &inflation, uint32_t a, uint32_t b) {
  if constexpr (requires { keep.at(a); })
    return keep.at(a);
  else if constexpr (Inflation::kDiffers && requires { keep.between(inflation.of(a), inflation.of(b)); })
    return keep.between(inflation.of(a), inflation.of(b));
  else
    return keep;
}

/// Where a search adds what it counted; null: another search counts that.
struct PairTotals {
  uint64_t *pairs, *first, *second;

  COLLIDED_HD void operator()(uint64_t all, uint64_t of_first, uint64_t of_second) const {
    if (pairs != nullptr && all != 0) atomic_add(*pairs, all);
    if (first != nullptr && of_first != 0) atomic_add(*first, of_first);
    if (second != nullptr && of_second != 0) atomic_add(*second, of_second);
  }
};

/// Pairs become candidates of features, and those that a filter keeps go to the lists of their kinds. Pairs of features
/// that are excluded are no candidates.
template <class Real, class Keep, class Tests = ElementaryTests<Real>, class Excluded = NothingExcluded>
struct FeatureSink {
  static constexpr bool kTakesPairs = false;
  static constexpr int kFirstOfSecondKind = kFirstEdgeEdge;
  static constexpr bool kKeepsAll = std::is_same_v<Keep, KeepAll>;
  using Number = Real;

  Tests tests;
  Keep keep;
  AppendList<uint64_t> vertex_triangle, edge_edge;
  uint32_t edge_rank;  ///< added to the first edge, where both kinds share a list
  EarlyExit early_exit;
  PairTotals totals;
  Excluded excluded = {};

  COLLIDED_HD uint32_t tests_of(uint32_t a, uint32_t b) const { return tests.tests_of(a, b); }
  /// Those that are not left to other elements.
  COLLIDED_HD static constexpr uint32_t wanted_tests(ElementRole a, ElementRole b, bool a_is_lower) {
    return Tests::wanted_tests(a, b, a_is_lower);
  }
  /// Whether the features share no vertex and their boxes overlap.
  COLLIDED_HD bool overlap_first(uint32_t a, uint32_t b, int test) const {
    return tests.vertex_triangle_overlap(a, b, test);
  }
  COLLIDED_HD bool overlap_second(uint32_t a, uint32_t b, int test) const {
    return tests.edge_edge_overlap(a, b, test);
  }
  /// As the tests do.
  template <FirstFeature kFirst>
  COLLIDED_HD bool confirms(const Box<float> &p, const Box<float> &q, const Stencil &stencil, uint32_t a,
                            uint32_t b) const {
    return tests.template confirms<kFirst>(p, q, stencil, a, b);
  }
  /// Whether features whose boxes overlap are no candidate all the same.
  COLLIDED_HD bool excludes_first(uint32_t a, uint32_t b, int test) const {
    return excluded.is_needed() && excluded.has_vertex_triangle(tests, a, b, test);
  }
  COLLIDED_HD bool excludes_second(uint32_t a, uint32_t b, int test) const {
    return excluded.is_needed() && excluded.has_edge_edge(tests, a, b, test);
  }
  /// Whether there is use in taking more (AppendList::push).
  COLLIDED_HD bool take_first(uint32_t a, uint32_t b, int test) const {
    const CandidatePoints<Real> candidate = tests.vertex_triangle_points(a, b, test);
    return !filter(a, b)(VertexTriangle{}, candidate.points) || vertex_triangle.push(candidate.key);
  }
  COLLIDED_HD bool take_second(uint32_t a, uint32_t b, int test) const {
    const CandidatePoints<Real> candidate = tests.edge_edge_points(a, b, test);
    return !filter(a, b)(EdgeEdge{}, candidate.points) || edge_edge.push(candidate.key + (uint64_t{edge_rank} << 32));
  }
  /// The same in two parts: whether the filter keeps a candidate, and its key.
  COLLIDED_HD bool keeps_first(uint32_t a, uint32_t b, int test) const {
    return kKeepsAll || filter(a, b)(VertexTriangle{}, tests.vertex_triangle_points(a, b, test).points);
  }
  COLLIDED_HD bool keeps_second(uint32_t a, uint32_t b, int test) const {
    return kKeepsAll || filter(a, b)(EdgeEdge{}, tests.edge_edge_points(a, b, test).points);
  }
  /// Returns the filter for features of triangles a < b.
  COLLIDED_HD Keep filter(uint32_t a, uint32_t b) const { return filter_of(keep, tests.inflation, a, b); }
  COLLIDED_HD uint64_t first_key(uint32_t vertex, uint32_t triangle) const { return pack_ids(vertex, triangle); }
  COLLIDED_HD uint64_t second_key(uint32_t edge, uint32_t other) const {
    return pack_ids(min(edge, other), max(edge, other)) + (uint64_t{edge_rank} << 32);
  }
  COLLIDED_HD bool is_over() const {
    return early_exit.is_over() || vertex_triangle.is_overfull() || edge_edge.is_overfull();
  }
  COLLIDED_HD void add(uint64_t pairs, uint64_t first, uint64_t second) const { totals(pairs, first, second); }
};

/// Pairs become tests of features that may touch (PackedTest), for the lists of neighbours.
template <class Real, class Tests>
struct NeighbourSink : FeatureSink<Real, MayTouchSoon<Real>, Tests> {
  static constexpr bool kListsTests = true;

  COLLIDED_HD bool take_first(uint32_t a, uint32_t b, int test) const {
    return !this->keeps_first(a, b, test) || this->vertex_triangle.push(PackedTest{a, b, test}.packed());
  }
  COLLIDED_HD bool take_second(uint32_t a, uint32_t b, int test) const {
    return !this->keeps_second(a, b, test) || this->edge_edge.push(PackedTest{a, b, test - kFirstEdgeEdge}.packed());
  }
};

/// Pairs of triangles that have few corners in common, and that no ring connects, are wanted as they are; loose
/// elements are in none.
struct TrianglePairSink {
  static constexpr bool kTakesPairs = true;

  WorldTable<Triangle> triangles;
  AppendList<uint64_t> pairs;
  uint32_t rank;  ///< added to the first triangle
  EarlyExit early_exit;
  PairTotals totals;
  VertexRings rings = {};
  int most_common = 0;  ///< corners of a pair that is wanted

  /// Whether there is use in taking more (AppendList::push).
  COLLIDED_HD bool take(uint32_t a, uint32_t b) const {
    uint64_t key;
    return !keeps(a, b, key) || pairs.push(key);
  }
  /// Whether a pair is wanted, whose key that is.
  COLLIDED_HD bool keeps(uint32_t a, uint32_t b, uint64_t &key) const {
    const Triangle p = triangles[a], q = triangles[b];
    key = pack_ids(a, b) + (uint64_t{rank} << 32);
    if (common_corners(p, q) > most_common || is_loose(p) || is_loose(q)) return false;
    return !rings.is_needed() || !rings.connect(p, q);
  }
  COLLIDED_HD bool is_over() const { return early_exit.is_over() || pairs.is_overfull(); }
  COLLIDED_HD void add(uint64_t all, uint64_t, uint64_t) const { totals(all, 0, 0); }

 protected:
  COLLIDED_HD static int common_corners(const Triangle &p, const Triangle &q) {
    return int{has(p, q.x)} + int{has(p, q.y)} + int{has(p, q.z)};
  }
  COLLIDED_HD static bool has(const Triangle &t, uint32_t v) { return t.x == v || t.y == v || t.z == v; }
};

}  // namespace collided
