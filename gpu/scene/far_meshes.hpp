#pragma once
// Which meshes go far in a step for the length of their edges. The boxes of a step span its ways: where these are much
// longer than triangles are large, boxes overlap that belong to no contact.

#include <algorithm>
#include <cmath>
#include <vector>

#include "gpu/step/buffers.hpp"

namespace collided {

/// How far the vertices of a mesh go, and how long its edges are, by its first few thousand.
template <Executor Exec, class Real>
class SampledMesh {
 public:
  SampledMesh(Exec& exec, const SceneBuffers<Exec, Real>& scene, const Topology& topology, uint32_t mesh)
      : first_(topology.vertex_offset[mesh]),
        count_(std::min(topology.vertex_offset[mesh + 1] - first_, kMaxVertices)),
        start_(count_),
        end_(count_) {
    exec.download(start_.data(), scene.start.data() + first_, count_ * sizeof(Vec3<Real>));
    exec.download(end_.data(), scene.end.data() + first_, count_ * sizeof(Vec3<Real>));
    measure_edges(topology, mesh);
  }

  double way() const {
    double longest = 0;
    for (uint32_t i = 0; i < count_; ++i) longest = std::max(longest, distance(start_[i], end_[i]));
    return longest;
  }
  /// 0 if it has none.
  double edge() const { return edges_ == 0 ? 0 : sum_ / static_cast<double>(edges_); }

 private:
  static constexpr uint32_t kMaxVertices = 4096, kMaxTriangles = 8192;

  static double distance(const Vec3<Real>& a, const Vec3<Real>& b) {
    const Vec3<double> d = convert<double>(b) - convert<double>(a);
    return std::sqrt(dot(d, d));
  }
  bool has(uint32_t vertex) const { return vertex >= first_ && vertex - first_ < count_; }
  void measure_edges(const Topology& topology, uint32_t mesh) {
    const uint32_t first = topology.triangle_offset[mesh];
    const uint32_t end = std::min(topology.triangle_offset[mesh + 1], first + kMaxTriangles);
    for (uint32_t t = first; t < end; ++t)
      for (size_t k = 0; k < 3; ++k) {
        const uint32_t a = topology.triangles[t][k], b = topology.triangles[t][(k + 1) % 3];
        if (a == b || !has(a) || !has(b)) continue;
        sum_ += distance(start_[a - first_], start_[b - first_]);
        ++edges_;
      }
  }

  uint32_t first_, count_;  ///< vertices
  std::vector<Vec3<Real>> start_, end_;
  double sum_ = 0;
  uint64_t edges_ = 0;
};

/// Of a scene of CCD that is no set, in the step that is resident.
template <Executor Exec, class Real>
std::vector<FrameProgress::FarMesh> far_meshes(Exec& exec, const SceneBuffers<Exec, Real>& scene,
                                               const Topology& topology) {
  constexpr size_t kMaxMeshes = 256;
  std::vector<FrameProgress::FarMesh> far;
  const size_t meshes = std::min(topology.vertex_offset.size() - 1, kMaxMeshes);
  for (uint32_t mesh = 0; mesh < meshes; ++mesh) {
    if (scene.topology.idle.has(mesh)) continue;  // costs nothing, however far it goes
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
