#pragma once
// The engine's functors over a StageScene: the one place that knows how to construct them.

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

#include "tests/bench/stages/stage_bench_scene.hpp"

namespace collided::test {

template <class Vector>
auto span_of(Vector& v) {
  return Span<std::remove_pointer_t<decltype(v.data())>>{v.data(), v.size()};
}

/// A list for what a functor finds.
template <class T>
class Found {
 public:
  explicit Found(uint64_t most) : items_(most) {}
  AppendList<T> list() { return {span_of(items_), &count_}; }
  void clear() { count_ = 0; }
  uint64_t count() const { return count_; }
  std::vector<T> take() {
    items_.resize(count_);
    return std::move(items_);
  }

 private:
  std::vector<T> items_;
  uint64_t count_ = 0;
};

/// The same for contacts.
class FoundContacts {
 public:
  explicit FoundContacts(uint64_t most) : keys_(most), data_(most), near_misses_(most), time_bits_(most) {}
  ContactSink<float> sink() { return {{keys_.list(), span_of(data_)}, EarlyExit{}, 0}; }
  NearMissList near_misses() { return {near_misses_.list(), span_of(time_bits_)}; }
  /// The functor that follows them to the end.
  template <class Kind, class Candidate>
  FollowNearMisses<float, Kind> follow(const CcdReporter<double, float, Kind, Candidate>& reporter) {
    const CcdQueries<float, Kind, Candidate>& q = reporter.queries;
    const Span<const uint64_t> keys = near_misses_.list().items, time_bits = span_of(time_bits_);
    return {{{q.start, q.end, q.thickness, q.doubt, q.delta, q.kind, keys},
             reporter.start_thickness,
             reporter.skips_separating,
             reporter.is_exact,
             reporter.contacts},
            time_bits,
            {near_misses_.list().count, keys.size()}};
  }
  uint64_t near_miss_count() const { return near_misses_.count(); }
  void clear() { keys_.clear(), near_misses_.clear(); }
  uint64_t count() const { return keys_.count(); }

 private:
  Found<uint64_t> keys_;
  std::vector<ContactData<float>> data_;
  Found<uint64_t> near_misses_;
  std::vector<uint64_t> time_bits_;
};

// The search for pairs, and the processing of pairs.

/// A sink that counts pairs.
struct CountPairs {
  static constexpr bool kTakesPairs = true;
  uint64_t* count;
  AppendList<uint64_t> pairs{};  ///< of none

  bool keeps(uint32_t, uint32_t, uint64_t&) const { return false; }
  bool is_over() const { return false; }
  void add(uint64_t all, uint64_t, uint64_t) const { *count += all; }
};

template <class Keep>
FeatureSink<float, Keep> feature_sink(const StageScene& s, const Keep& keep, Found<uint64_t>& vertex_triangle,
                                      Found<uint64_t>& edge_edge) {
  StepState& state = s.state();
  return {s.boxes.elementary({.vertex_triangle = true, .edge_edge = true}),
          keep,
          vertex_triangle.list(),
          edge_edge.list(),
          0,
          EarlyExit{},
          {&state.pairs, &state.candidates[0], &state.candidates[1]}};
}

/// The boxes of all triangles' features, which CpuExec prepares before a search for candidates.
template <class Sink>
std::vector<FeatureBoxes> feature_boxes(const StageScene& s, const Sink& sink) {
  std::vector<FeatureBoxes> out;
  out.reserve(s.triangles());
  for (uint32_t t = 0; t < s.triangles(); ++t) out.push_back(feature_boxes_of(sink.tests, t));
  return out;
}
/// Hands the step's pairs to a sink, in the order that the search finds them in.
template <class Sink>
void take_pairs(const StageScene& s, const Sink& sink, const std::vector<FeatureBoxes>& features) {
  CandidateTaker<Sink> taker(sink, features.data());
  for (const auto& [a, b] : s.pairs) taker.take(a, b);
  taker.finish();
}

inline MaybeCoplanar<float> coplanarity_filter(const StageScene& s) { return {&s.step.filter}; }

/// Leaves of two tiles each, all in one cell: one item, the first tile against the second, for each of them.
inline LeafPairs tile_pairs(const LevelGrid& grid, Span<const Box<float>> boxes, const std::vector<Leaf>& leaves,
                            const std::vector<uint32_t>& members, const std::vector<PairItem>& items,
                            const LeafTotals& totals) {
  return {&grid, {}, boxes, span_of(leaves), span_of(members), span_of(items), &totals, members.size()};
}

inline MortonKeys morton_keys(const StageScene& s) {
  const BvhBuffers<CpuExec>& bvh = s.hierarchy.buffers();
  return {&s.state().bounds,      {&s.state().bounds, &s.state().extents, s.triangles()},
          s.buffers.boxes.all(),  bvh.keys[0].all(),
          bvh.triangles[0].all(), bvh.meeting.all()};
}

// The narrow phase.

template <class Kind>
FeaturePoints<float> points_of_key(const StageScene& s, uint64_t key) {
  return points_of(s.kind<Kind>().stencil(key), s.buffers.start.data(), s.buffers.end.data());
}

template <class Kind, class Candidate>
CcdQueries<float, Kind, Candidate> queries(const StageScene& s, const std::vector<Candidate>& candidates) {
  return {s.buffers.start.data(), s.buffers.end.data(), s.spec.thickness,   {},
          s.spec.delta,           s.kind<Kind>(),       span_of(candidates)};
}

template <class Kind>
ScreenCcd<float, Kind> screen(const StageScene& s, const std::vector<uint64_t>& candidates, Found<uint64_t>& found) {
  return {queries<Kind>(s, candidates), found.list()};
}
template <class Kind>
ApproachCcd<float, Kind> approach(const StageScene& s, const std::vector<uint64_t>& candidates,
                                  Found<ResumableQuery>& found) {
  return {queries<Kind>(s, candidates), found.list()};
}
template <class Work, class Kind, class Candidate>
AdvanceCcd<Work, float, Kind, Candidate> advance_to_the_end(const StageScene& s,
                                                            const std::vector<Candidate>& candidates,
                                                            FoundContacts& found) {
  return {{queries<Kind>(s, candidates), 0, false, false, found.sink()}, found.near_misses()};
}

/// A query that advances in double from t = 0.
template <class Kind>
struct QueryFromStart {
  DifferencesOf<double, Kind> d;

  /// The advancement when it is over, and the looks that it took.
  std::pair<AdvancementOf<double, Kind>, int> run() const {
    std::pair<AdvancementOf<double, Kind>, int> out;
    auto& [features, looks] = out;
    features.d = d;
    features.begin({{0, 0}, default_delta(0.0) * d.extent}, {}, kMaxIterations);
    for (looks = 0; !features.is_over(); ++looks) features.iterate(1.0);
    return out;
  }
  bool is_certain_at(double t) const { return certain_by(d, t, 0.0) < kNeverCertain; }
};
template <class Kind>
std::vector<QueryFromStart<Kind>> queries_from_start(const StageScene& s, const std::vector<uint64_t>& candidates) {
  std::vector<QueryFromStart<Kind>> out;
  const auto query = queries<Kind>(s, candidates);
  for (uint64_t i = 0; i < candidates.size(); ++i)
    if (QueryFromStart<Kind> one; query.load(i, one.d)) out.push_back(one);
  return out;
}

template <class Kind>
SolveCubicCcd<float, Kind> solve_cubic(const StageScene& s, const std::vector<uint64_t>& candidates,
                                       FoundContacts& found) {
  return {s.buffers.start.data(), s.buffers.end.data(), 0, s.kind<Kind>(), span_of(candidates), found.sink()};
}

/// The coplanarity cubic of a candidate.
template <class Kind>
Cubic<float> cubic_of(const StageScene& s, uint64_t key) {
  const FeaturePoints<float> points = points_of_key<Kind>(s, key);
  Vec3<float> x[3], y[3];
  spanning_vectors(s.kind<Kind>(), points.start, x);
  spanning_vectors(s.kind<Kind>(), points.end, y);
  return moving_triple(x, y);
}

template <class Kind>
TestProximity<float, Kind> test_proximity(const StageScene& s, const std::vector<uint64_t>& candidates,
                                          FoundContacts& found) {
  return {s.buffers.end.data(), static_cast<float>(s.thickness_at_rest), s.kind<Kind>(), span_of(candidates),
          found.sink()};
}
template <class Work, class Kind>
CertifyProximity<Work, float, Kind> certify_proximity(const StageScene& s, const std::vector<uint64_t>& candidates,
                                                      FoundContacts& found) {
  return {s.buffers.end.data(), s.thickness_at_rest,     0, s.kind<Kind>(), span_of(candidates),
          found.sink(),         found.near_misses().keys};
}

/// Runs a functor over all items, on this thread, as CpuExec does: in ranges, one by one, or in steps.
template <class F>
void run_all(uint64_t n, const F& f) {
  if constexpr (HasRanges<F>) {
    for (uint64_t i = 0; i < n; i += InRanges<F>::kItems)
      InRanges<F>::run(f, i, std::min<uint64_t>(n, i + InRanges<F>::kItems));
    return;
  }
  for (uint64_t i = 0; i < n; ++i) {
    if constexpr (requires { typename F::State; })
      do_resumable(f, i);
    else
      f(i);
  }
}

}  // namespace collided::test
