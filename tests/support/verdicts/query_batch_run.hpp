#pragma once
// run_queries() on one backend: the queries become separate triangles or edges, with one candidate each.

#include <cmath>

#include "gpu/contacts/scene_counts.hpp"
#include "gpu/step/narrow_phase.hpp"
#include "gpu/step/results.hpp"
#include "gpu/step/sinks.hpp"
#include "tests/support/verdicts/query_batch.hpp"

namespace collided::test {

/// Four positions of each query, from p[first] on.
template <class Real>
std::vector<Vec3<Real>> batch_positions(std::span<const Query> queries, size_t first) {
  std::vector<Vec3<Real>> out;
  for (const Query& q : queries)
    for (size_t k = first; k < first + 4; ++k)
      out.push_back({static_cast<Real>(q.p[k][0]), static_cast<Real>(q.p[k][1]), static_cast<Real>(q.p[k][2])});
  return out;
}

/// Largest extent of a query, as a scene's bounds would give it.
template <class Real>
float batch_extent(const std::vector<Vec3<Real>>& start, const std::vector<Vec3<Real>>& end) {
  Real extent = 0;
  for (size_t i = 0; i < start.size(); ++i) {
    const Vec3<Real> origin = start[i / 4 * 4];
    extent = max(extent, max(largest_component(start[i] - origin), largest_component(end[i] - origin)));
  }
  return static_cast<float>(extent);
}

/// What the search for pairs does with a candidate: the filter of the level.
template <class Real, class Kind, class Keep>
struct FilterQueries {
  const Vec3<Real>* start;
  const Vec3<Real>* end;
  Kind kind;
  Keep keep;
  Span<const uint64_t> keys;
  AppendList<uint64_t> kept;

  COLLIDED_HD void operator()(uint64_t i) const {
    if (keep(kind, points_of(kind.stencil(keys[i]), start, end))) kept.push(keys[i]);
  }
};

struct SetBounds {
  StepState* state;
  float extent;
  COLLIDED_HD void operator()(uint64_t) const { state->bounds = {{0, 0, 0}, {extent, extent, extent}}; }
};

/// The narrow phase of queries that lie in a scene's buffers.
template <Executor Exec, class Real>
class QueryRun {
 public:
  QueryRun(Exec& exec, const BatchSettings& settings, const FeatureRanks& ranks, SceneBuffers<Exec, Real>& scene)
      : exec_(exec),
        ranks_(ranks),
        scene_(scene),
        narrow_(exec, ranks_, scene),
        placing_(exec, scene),
        results_(exec, spec_, scene, placing_) {
    spec_.mode = settings.mode;
    spec_.thickness = settings.thickness;
    spec_.accuracy = settings.accuracy;
    spec_.delta = settings.delta;
    needs_ = needs_of(spec_, settings_of(spec_, {}));
  }

  template <class Kind>
  FrameResult run(const Kind& kind, Span<const uint64_t> keys, float extent) {
    FrameResult result;
    exec_.begin_frame();
    for (;;) {
      const StepPlan plan{.needs = needs_, .order = narrow_.plan_order()};
      narrow_.begin(plan);
      narrow_.reserve();
      const StepState state =
          exec_.step(numbers_.number_of(plan), scene_.state.data(), [&] { enqueue(kind, keys, extent); });
      const bool grew = narrow_.grow(state, 0), reorders = narrow_.reorders(state);
      if (grew || reorders) continue;
      results_.collect(state, needs_, {}, result);
      return result;
    }
  }

 private:
  template <class Kind>
  void enqueue(const Kind& kind, Span<const uint64_t> keys, float extent) {
    StepState* state = scene_.state.data();
    exec_.fill_zero(state, sizeof(StepState));
    exec_.for_each("prepare", 1, SetBounds{state, extent});
    exec_.for_each("prepare_narrow", 1, PrepareNarrow{state, spec_.thickness});
    with_filter<Real>(needs_, spec_.thickness, state, [&](const auto& keep) { filter(kind, keys, keep); });
    narrow_.detect(kind, [](const auto& put) { put(); });
    narrow_.finish();
  }
  template <class Kind, class Keep>
  void filter(const Kind& kind, Span<const uint64_t> keys, const Keep& keep) {
    exec_.for_each("filter_queries", keys.size(),
                   FilterQueries<Real, Kind, Keep>{scene_.positions_at_start(needs_.is_ccd()), scene_.end.data(), kind,
                                                   keep, keys, narrow_.kept(Kind::kKind)});
  }

  Exec& exec_;
  const FeatureRanks& ranks_;
  SceneBuffers<Exec, Real>& scene_;
  SceneSpec spec_;
  LevelNeeds needs_;
  NarrowPhase<Exec, Real> narrow_;
  Placing<Exec, Real> placing_;
  Results<Exec, Real> results_;
  PlanNumbers numbers_;
};

template <Executor Exec, class Real>
ContactSet run_batch(Exec& exec, std::span<const Query> queries, const BatchSettings& settings) {
  SceneBuffers<Exec, Real> scene(exec);
  const auto send = [&](auto& buffer, const auto& values) {
    buffer.allocate(values.size());
    exec.upload(buffer.data(), values.data(), values.size() * sizeof(values[0]));
    exec.wait();  // for the copy: `values` may go
  };
  const auto start = batch_positions<Real>(queries, 0), end = batch_positions<Real>(queries, 4);
  if (settings.mode == Mode::kCcd) send(scene.start, start);
  send(scene.end, end);
  scene.state.allocate(1);
  const bool is_vt = queries.front().kind == QueryKind::kVertexTriangle;
  std::vector<uint64_t> keys;
  std::vector<Vec3<uint32_t>> triangles;
  std::vector<EdgePair> edges;
  for (uint32_t i = 0; i < queries.size(); ++i) {
    keys.push_back(is_vt ? pack_ids(4 * i, i) : pack_ids(2 * i, 2 * i + 1));
    triangles.push_back({4 * i + 1, 4 * i + 2, 4 * i + 3});
    edges.insert(edges.end(), {{4 * i, 4 * i + 1}, {4 * i + 2, 4 * i + 3}});
  }
  Buffer<uint64_t, Exec> resident(exec, "queries");
  send(resident, keys);
  send(scene.topology.triangles, triangles);
  send(scene.topology.edges, edges);

  SceneCounts counts;
  counts.vertices = 4 * queries.size(), counts.edges = edges.size();
  const FeatureRanks ranks = ranks_of({.vertex_triangle = true, .edge_edge = true}, counts);
  QueryRun<Exec, Real> run(exec, settings, ranks, scene);
  const float extent = batch_extent(start, end);
  if (is_vt) return run.run(VertexTriangle{scene.topology.triangles.all()}, resident.all(), extent).vertex_triangle;
  return run.run(EdgeEdge{scene.topology.edges.all()}, resident.all(), extent).edge_edge;
}

template <Executor Exec>
std::vector<Verdict> run_queries_on(Exec& exec, std::span<const Query> queries, const BatchSettings& settings) {
  std::vector<Verdict> verdicts(queries.size());
  if (queries.empty()) return verdicts;
  const ContactSet found = settings.scalar == Scalar::kF32 ? run_batch<Exec, float>(exec, queries, settings)
                                                           : run_batch<Exec, double>(exec, queries, settings);
  const bool is_vt = queries.front().kind == QueryKind::kVertexTriangle;
  for (size_t i = 0; i < found.size(); ++i) {
    const uint32_t query = is_vt ? found.elements[i][1] : found.elements[i][0] / 2;
    verdicts[query] = {true, found.toi.empty() ? 0 : found.toi[i], found.distance[i], found.flags[i]};
  }
  return verdicts;
}

std::vector<Verdict> run_queries_cpu(std::span<const Query> queries, const BatchSettings& settings);
/// Throws DeviceError where the build or the machine has no CUDA.
std::vector<Verdict> run_queries_cuda(std::span<const Query> queries, const BatchSettings& settings);

}  // namespace collided::test
