#pragma once
// run_queries() on one backend: the queries become separate triangles or edges, with one candidate each.

#include <cmath>

#include "gpu/narrow_phase.hpp"
#include "tests/support/query_batch.hpp"

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
    extent = larger(extent, larger(largest_component(start[i] - origin), largest_component(end[i] - origin)));
  }
  return static_cast<float>(extent);
}

template <class Exec, class Real>
ContactSet run_batch(Exec& exec, std::span<const Query> queries, const BatchSettings& settings) {
  SceneSpec spec;
  spec.mode = settings.mode;
  spec.thickness = settings.thickness;
  SceneBuffers<Exec, Real> scene(exec);
  const auto send = [&](auto& buffer, const auto& values) {
    buffer.allocate(values.size());
    exec.upload(buffer.data(), values.data(), values.size() * sizeof(values[0]));
    exec.read(buffer.data());  // waits for the copy: `values` may go
  };
  const auto start = batch_positions<Real>(queries, 0), end = batch_positions<Real>(queries, 4);
  send(scene.start, start);
  send(scene.end, end);
  const bool is_vt = queries.front().kind == QueryKind::kVertexTriangle;
  std::vector<uint64_t> keys;
  std::vector<Vec3<uint32_t>> triangles;
  std::vector<EdgePair> edges;
  for (uint32_t i = 0; i < queries.size(); ++i) {
    keys.push_back(is_vt ? pack_ids(4 * i, i) : pack_ids(2 * i, 2 * i + 1));
    triangles.push_back({4 * i + 1, 4 * i + 2, 4 * i + 3});
    edges.insert(edges.end(), {{4 * i, 4 * i + 1}, {4 * i + 2, 4 * i + 3}});
  }
  send(scene.candidates, keys);
  send(scene.topology.triangles, triangles);
  send(scene.topology.edges, edges);

  FrameResult result;
  NarrowPhase<Exec, Real> narrow(exec, spec, scene);
  exec.begin_frame();
  narrow.begin({settings.accuracy, settings.delta, Report::kAll}, batch_extent(start, end), result);
  const Span<uint64_t> candidates = scene.candidates.span(keys.size());
  if (is_vt)
    narrow.detect(VertexTriangle{scene.topology.triangles.all()}, candidates);
  else
    narrow.detect(EdgeEdge{scene.topology.edges.all()}, candidates);
  narrow.finish();
  return std::move(is_vt ? result.vertex_triangle : result.edge_edge);
}

template <class Exec>
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
