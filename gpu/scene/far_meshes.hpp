#pragma once
// Which meshes go far in a step for the length of their edges. The boxes of a step span its ways: where these are much
// longer than triangles are large, boxes overlap that belong to no contact.

#include <algorithm>
#include <cmath>
#include <vector>

#include "gpu/state/buffers.hpp"

namespace collided {

/// Samples how far the vertices of a mesh go and how long its edges are. A large mesh is sampled by runs of vertices
/// that are spread evenly over it: neighbours in number mostly are neighbours in space, and have edges.
template <Executor Exec, class Real>
class SampledMesh {
 public:
  SampledMesh(Exec& exec, const SceneBuffers<Exec, Real>& scene, const Topology& topology, uint32_t mesh)
      : first_(topology.vertex_offset[mesh]), vertices_(topology.vertex_offset[mesh + 1] - first_) {
    const bool is_whole = vertices_ <= kRuns * kRun;
    run_ = is_whole ? vertices_ : kRun;
    step_ = is_whole ? vertices_ : (vertices_ - kRun) / (kRuns - 1);
    const uint32_t runs = is_whole ? 1 : kRuns;
    start_.resize(size_t{runs} * run_), end_.resize(size_t{runs} * run_);
    for (uint32_t run = 0; run < runs; ++run) {
      const uint32_t from = first_ + run * step_;
      exec.download(start_.data() + run * run_, scene.start.data() + from, run_ * sizeof(Vec3<Real>));
      exec.download(end_.data() + run * run_, scene.end.data() + from, run_ * sizeof(Vec3<Real>));
    }
    measure_edges(topology, mesh);
  }

  double way() const {
    double longest = 0;
    for (size_t i = 0; i < start_.size(); ++i) longest = std::max(longest, distance(start_[i], end_[i]));
    return longest;
  }
  /// 0 if it has none.
  double edge() const { return edges_ == 0 ? 0 : sum_ / static_cast<double>(edges_); }

 private:
  static constexpr uint32_t kRuns = 8, kRun = 512, kMaxTriangles = 8192;

  static double distance(const Vec3<Real>& a, const Vec3<Real>& b) {
    const Vec3<double> d = convert<double>(b) - convert<double>(a);
    return std::sqrt(dot(d, d));
  }
  /// Returns where a vertex starts; null if it was not sampled.
  const Vec3<Real>* start_of(uint32_t vertex) const {
    const uint32_t v = vertex - first_;
    const uint32_t run = std::min<uint32_t>(v / step_, static_cast<uint32_t>(start_.size() / run_) - 1);
    return v - run * step_ < run_ ? &start_[size_t{run} * run_ + (v - run * step_)] : nullptr;
  }
  void measure_edges(const Topology& topology, uint32_t mesh) {
    const uint32_t first = topology.triangle_offset[mesh], count = topology.triangle_offset[mesh + 1] - first;
    const uint32_t looked_at = std::min(count, kMaxTriangles);
    for (uint64_t i = 0; i < looked_at; ++i) {
      const auto& triangle = topology.triangles[first + i * count / looked_at];
      for (size_t k = 0; k < 3; ++k) {
        const Vec3<Real>*a = start_of(triangle[k]), *b = start_of(triangle[(k + 1) % 3]);
        if (a == b || !a || !b) continue;
        sum_ += distance(*a, *b);
        ++edges_;
      }
    }
  }

  uint32_t first_, vertices_;    ///< of the mesh
  uint32_t run_ = 0, step_ = 0;  ///< vertices of a run, and from one's begin to the next one's
  std::vector<Vec3<Real>> start_, end_;
  double sum_ = 0;
  uint64_t edges_ = 0;
};

/// Returns the meshes that go far in the step that is resident, in a scene of CCD that is no set. Of very many meshes
/// some are looked at, spread evenly.
template <Executor Exec, class Real>
std::vector<FrameProgress::FarMesh> far_meshes(Exec& exec, const SceneBuffers<Exec, Real>& scene,
                                               const Topology& topology) {
  constexpr size_t kMaxMeshes = 256;
  std::vector<FrameProgress::FarMesh> far;
  const size_t meshes = topology.vertex_offset.size() - 1, looked_at = std::min(meshes, kMaxMeshes);
  for (size_t i = 0; i < looked_at; ++i) {
    const auto mesh = static_cast<uint32_t>(i * meshes / looked_at);
    const bool is_empty = topology.vertex_offset[mesh + 1] == topology.vertex_offset[mesh];
    if (is_empty || scene.topology.idle.has(mesh)) continue;  // an idle one costs nothing, however far it goes
    const SampledMesh<Exec, Real> sampled(exec, scene, topology, mesh);
    const double way = sampled.way(), edge = sampled.edge();
    if (edge > 0 && way > edge) far.push_back({mesh, way, edge});
  }
  std::stable_sort(far.begin(), far.end(),
                   [](const auto& a, const auto& b) { return a.way * b.edge > b.way * a.edge; });
  if (far.size() > FrameProgress::kMaxFarMeshes) far.resize(FrameProgress::kMaxFarMeshes);
  return far;
}

}  // namespace collided
