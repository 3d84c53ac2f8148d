// Benchmarks of single queries of the narrow phase; an item is one query, a run goes through all of the step's.

#include "tests/bench/stages/stage_bench.hpp"
#include "tests/bench/stages/stage_bench_functors.hpp"

namespace collided::test {
namespace {

/// Times a functor over n items; counts the share for which it finds something.
template <class F, class List>
void measure_functor(benchmark::State& state, uint64_t n, const F& f, List& found) {
  measure(
      state, n, [&] { found.clear(); }, [&] { run_all(n, f); });
  state.counters["share_found"] = static_cast<double>(found.count()) / static_cast<double>(n);
}

/// At most `most` items, spread over the list.
template <class T>
std::vector<T> spread(const std::vector<T>& list, size_t most) {
  if (list.size() <= most) return list;
  std::vector<T> out;
  for (size_t i = 0; i < most; ++i) out.push_back(list[i * list.size() / most]);
  return out;
}

template <class Kind>
void bench_filter(const StageScene& s, benchmark::State& state) {
  std::vector<FeaturePoints<float>> points;  // at hand in the engine, too
  for (const uint64_t key : s.lists<Kind>().candidates) points.push_back(points_of_key<Kind>(s, key));
  const MaybeCoplanar<float> keep = coplanarity_filter(s);
  const Kind kind = s.kind<Kind>();
  uint64_t kept = 0;
  measure(
      state, points.size(), [&] { kept = 0; },
      [&] {
        for (const FeaturePoints<float>& p : points) kept += keep(kind, p) ? 1 : 0;
      });
  state.counters["share_found"] = static_cast<double>(kept) / static_cast<double>(points.size());
}

template <class Kind>
void bench_screen(const StageScene& s, benchmark::State& state) {
  const std::vector<uint64_t>& kept = s.lists<Kind>().kept;
  Found<uint64_t> found(kept.size());
  measure_functor(state, kept.size(), screen<Kind>(s, kept, found), found);
}

template <class Kind>
void bench_approach(const StageScene& s, benchmark::State& state) {
  const std::vector<uint64_t>& screened = s.lists<Kind>().screened;
  Found<ResumableQuery> found(screened.size());
  measure_functor(state, screened.size(), approach<Kind>(s, screened, found), found);
}

/// Contact and its certificate, from where the candidates got so far.
template <class Work, class Kind, class Candidate>
void bench_advance(const StageScene& s, const std::vector<Candidate>& candidates, benchmark::State& state) {
  FoundContacts found(candidates.size());
  measure_functor(state, candidates.size(), advance_to_the_end<Work, Kind>(s, candidates, found), found);
}

/// What is left of it: pairs that may be near misses.
template <class Kind>
void bench_near_misses(const StageScene& s, benchmark::State& state) {
  const std::vector<ResumableQuery>& candidates = s.lists<Kind>().near;
  FoundContacts near(candidates.size()), found(candidates.size());
  const auto advance = advance_to_the_end<double, Kind>(s, candidates, near);
  run_all(candidates.size(), advance);
  FollowNearMisses<float, Kind> follow = near.follow(advance.reporter);
  follow.reporter.contacts = found.sink();
  const auto follow_alone = [&](uint64_t i) {
    Nothing shared;
    follow(i, Group{0, 1}, shared);
  };
  measure_functor(state, near.near_miss_count(), follow_alone, found);
}

/// The advancement alone, in double and from t = 0, with the looks that it takes.
template <class Kind>
void bench_advancement(const StageScene& s, benchmark::State& state) {
  const std::vector<QueryFromStart<Kind>> all = queries_from_start<Kind>(s, s.lists<Kind>().screened);
  uint64_t looks = 0;
  measure(
      state, all.size(), [&] { looks = 0; },
      [&] {
        for (const QueryFromStart<Kind>& one : all) looks += static_cast<uint64_t>(one.run().second);
      });
  state.counters["looks"] = static_cast<double>(looks) / static_cast<double>(all.size());
}

/// The certificate alone, of the contacts among them.
template <class Kind>
void bench_certificate(const StageScene& s, benchmark::State& state) {
  std::vector<std::pair<QueryFromStart<Kind>, double>> hits;
  for (const QueryFromStart<Kind>& one : queries_from_start<Kind>(s, s.lists<Kind>().screened))
    if (const auto found = one.run().first; found.is_hit()) hits.emplace_back(one, found.time());
  uint64_t certain = 0;
  measure(
      state, hits.size(), [&] { certain = 0; },
      [&] {
        for (const auto& [one, t] : hits) certain += one.is_certain_at(t) ? 1 : 0;
      });
  state.counters["share_found"] = static_cast<double>(certain) / static_cast<double>(hits.size());
}

template <class Kind>
void bench_cubic(const StageScene& s, benchmark::State& state) {
  const std::vector<uint64_t>& candidates = s.lists<Kind>().candidates;
  FoundContacts found(candidates.size());
  measure_functor(state, candidates.size(), solve_cubic<Kind>(s, candidates, found), found);
}

/// Roots alone, of cubics that have some or may have.
template <class Kind>
void bench_roots(const StageScene& s, benchmark::State& state) {
  std::vector<Cubic<float>> cubics;
  for (const uint64_t key : s.lists<Kind>().candidates)
    if (const Cubic<float> f = cubic_of<Kind>(s, key); !f.one_sided()) cubics.push_back(f);
  uint64_t roots = 0;
  measure(
      state, cubics.size(), [&] { roots = 0; },
      [&] {
        for (const Cubic<float>& f : cubics) {
          float at[3];
          roots += static_cast<uint64_t>(roots_in_unit(f, at));
          benchmark::DoNotOptimize(at);
        }
      });
  state.counters["roots"] = static_cast<double>(roots) / static_cast<double>(cubics.size());
}

template <class Kind>
void bench_proximity(const StageScene& s, benchmark::State& state) {
  const std::vector<uint64_t>& candidates = s.lists<Kind>().candidates;
  FoundContacts found(candidates.size());
  measure_functor(state, candidates.size(), test_proximity<Kind>(s, candidates, found), found);
}
template <class Work, class Kind>
void bench_certified_proximity(const StageScene& s, benchmark::State& state) {
  const std::vector<uint64_t>& candidates = s.lists<Kind>().candidates;
  FoundContacts found(candidates.size());
  measure_functor(state, candidates.size(), certify_proximity<Work, Kind>(s, candidates, found), found);
}

/// Exact decisions on what float could not separate, the hardest part of a step.
template <class Kind>
void bench_exact(const StageScene& s, benchmark::State& state) {
  std::vector<FeaturePoints<double>> points;
  for (const ResumableQuery& suspect : spread(s.lists<Kind>().near, 256)) {
    const FeaturePoints<float> p = points_of_key<Kind>(s, suspect.key);
    FeaturePoints<double>& wide = points.emplace_back();
    for (int k = 0; k < 4; ++k) wide.start[k] = convert<double>(p.start[k]), wide.end[k] = convert<double>(p.end[k]);
  }
  uint64_t hits = 0;
  measure(
      state, points.size(), [&] { hits = 0; },
      [&] {
        for (const FeaturePoints<double>& p : points) hits += exact_ccd(Kind::kKind, p.start, p.end, 0).hit ? 1 : 0;
      });
  state.counters["share_found"] = static_cast<double>(hits) / static_cast<double>(points.size());
}

template <class Kind>
void register_kind(const StageScene& s, const std::string& kind) {
  add("filter/never_coplanar/" + kind, [&s](auto& state) { bench_filter<Kind>(s, state); });
  add("separation/screen/" + kind, [&s](auto& state) { bench_screen<Kind>(s, state); });
  add("separation/approach_float/" + kind, [&s](auto& state) { bench_approach<Kind>(s, state); });
  add("separation/advance_double/" + kind,
      [&s](auto& state) { bench_advance<double, Kind>(s, s.lists<Kind>().near, state); });
  add("separation/advance_double_from_start/" + kind,
      [&s](auto& state) { bench_advance<double, Kind>(s, s.lists<Kind>().screened, state); });
  add("separation/advance_float_from_start/" + kind,
      [&s](auto& state) { bench_advance<float, Kind>(s, s.lists<Kind>().screened, state); });
  add("separation/near_misses/" + kind, [&s](auto& state) { bench_near_misses<Kind>(s, state); });
  add("separation/look_double/" + kind, [&s](auto& state) { bench_advancement<Kind>(s, state); });
  add("separation/certificate/" + kind, [&s](auto& state) { bench_certificate<Kind>(s, state); });
  add("fast/solve_cubic/" + kind, [&s](auto& state) { bench_cubic<Kind>(s, state); });
  add("fast/roots_in_unit/" + kind, [&s](auto& state) { bench_roots<Kind>(s, state); });
  add("proximity/fast/" + kind, [&s](auto& state) { bench_proximity<Kind>(s, state); });
  add("proximity/certify_float/" + kind, [&s](auto& state) { bench_certified_proximity<float, Kind>(s, state); });
  add("proximity/certify_double/" + kind, [&s](auto& state) { bench_certified_proximity<double, Kind>(s, state); });
  add("exact/ccd/" + kind, [&s](auto& state) { bench_exact<Kind>(s, state); });
}

}  // namespace

void register_queries(StageScene& scene) {
  register_kind<VertexTriangle>(scene, "vertex_triangle");
  register_kind<EdgeEdge>(scene, "edge_edge");
}

}  // namespace collided::test
