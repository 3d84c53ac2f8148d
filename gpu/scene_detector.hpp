#pragma once
// A scene on one backend: keeps positions resident, applies frames atomically, runs the pipeline.

#include <algorithm>
#include <cstring>
#include <utility>

#include "gpu/frame_check.hpp"
#include "gpu/pipeline.hpp"

namespace collided {

template <class Exec, class Real>
class SceneDetector final : public Detector {
 public:
  template <class... ExecArgs>
  SceneDetector(SceneSpec spec, FeatureTables features, ExecArgs... args)
      : spec_(std::move(spec)),
        topology_(std::move(features.topology)),
        exec_(args...),
        scene_(exec_),
        pipeline_(exec_, spec_, topology_, scene_),
        last_good_(uint64_t{topology_.vertex_count} * sizeof(Vec3<Real>)) {
    for (MeshSpec& mesh : spec_.meshes) mesh.triangles = {};  // the scene-wide tables hold them now
    make_resident(features);
  }

  FrameResult detect(const FrameInput& frame) override {
    check_frame(spec_, frame, !has_frame_);
    const FrameSettings settings = settings_of(spec_, frame);
    exec_.begin_frame();
    exec_.cancelled = frame.cancelled;
    try {
      if (spec_.edge_edge && settings.accuracy != Accuracy::kCandidates) require_edges();
      const bool all = stale_ || !has_frame_;
      exec_.stage("upload", [&] { upload(frame); });
      FrameResult result = pipeline_.detect_contacts(moved(all), all, settings);
      commit(frame);
      return result;
    } catch (...) {
      stale_ = true;
      throw;
    }
  }

  std::vector<MemoryPart> memory() const override { return exec_.ledger().parts(); }
  const Topology& topology() const override { return topology_; }
  DeviceInfo device() const override { return exec_.device(); }

 private:
  void make_resident(const FeatureTables& features) {
    ResidentTopology<Exec>& resident = scene_.topology;
    send(resident.triangles, topology_.triangles);
    send(resident.owned, features.owned);
    if (spec_.edge_edge) send(resident.triangle_edges, features.triangle_edges);
    if (spec_.edge_edge && spec_.accuracy != Accuracy::kCandidates) require_edges();
    if (needs_filter()) {
      send(resident.mesh_of_triangle, features.mesh_of_triangle);
      send(resident.rules, rules());
    }
    scene_.boxes.allocate(topology_.triangles.size());
    scene_.records.allocate(topology_.triangles.size());
    scene_.end.allocate(topology_.vertex_count);
    if (spec_.mode == Mode::kCcd) scene_.start.allocate(topology_.vertex_count);
  }

  /// A frame may ask for more accuracy than the scene.
  void require_edges() {
    if (scene_.topology.edges.capacity() == 0) send(scene_.topology.edges, topology_.edges);
  }

  template <class T, class U>
  void send(Buffer<T, Exec>& to, const std::vector<U>& from) {
    static_assert(sizeof(T) == sizeof(U));
    to.allocate(from.size());
    exec_.upload(to.data(), from.data(), from.size() * sizeof(T));
  }

  std::vector<MeshRule> rules() const {
    std::vector<MeshRule> out;
    for (const MeshSpec& m : spec_.meshes)
      out.push_back({m.groups, m.collide_mask, m.is_static ? 1u : 0u, m.self_contacts ? 1u : 0u});
    return out;
  }
  /// Whether some pair of meshes may not touch.
  bool needs_filter() const {
    const auto free = [](const MeshSpec& m) {
      return m.groups == 1 && m.collide_mask == ~0u && m.self_contacts && !m.is_static;
    };
    return !std::all_of(spec_.meshes.begin(), spec_.meshes.end(), free);
  }

  uint64_t mesh_bytes(uint32_t mesh) const { return spec_.meshes[mesh].vertex_count * sizeof(Vec3<Real>); }
  std::byte* last_good(uint32_t mesh) { return last_good_.data() + topology_.vertex_offset[mesh] * sizeof(Vec3<Real>); }

  /// Brings the frame's positions to the backend.
  void upload(const FrameInput& frame) {
    if (stale_ && has_frame_) exec_.upload(scene_.end.data(), last_good_.data(), last_good_.size());
    if (spec_.mode == Mode::kCcd && has_frame_)
      exec_.copy(scene_.start.data(), scene_.end.data(), topology_.vertex_count * sizeof(Vec3<Real>));
    for (const MeshPositions& update : frame.updates) upload_mesh(update);
  }

  /// The triangles that have to be boxed: all, or those of meshes that move.
  std::vector<TriangleRun> moved(bool all) const {
    std::vector<TriangleRun> runs;
    for (uint32_t mesh = 0; mesh < spec_.meshes.size(); ++mesh)
      if (all || !spec_.meshes[mesh].is_static) append_run(runs, mesh);
    return runs;
  }

  void upload_mesh(const MeshPositions& update) {
    const uint64_t first = topology_.vertex_offset[update.mesh];
    const uint64_t bytes = mesh_bytes(update.mesh);
    exec_.upload(scene_.end.data() + first, update.end.data(), bytes);
    if (spec_.mode != Mode::kCcd) return;
    if (!update.start.empty())
      exec_.upload(scene_.start.data() + first, update.start.data(), bytes);
    else if (!has_frame_)
      exec_.copy(scene_.start.data() + first, scene_.end.data() + first, bytes);
  }

  void append_run(std::vector<TriangleRun>& runs, uint32_t mesh) const {
    const uint64_t first = topology_.triangle_offset[mesh], end = topology_.triangle_offset[mesh + 1];
    if (!runs.empty() && runs.back().first + runs.back().count == first)
      runs.back().count += end - first;
    else
      runs.push_back({first, end - first});
  }

  /// The frame counts from here on; its positions are what a later failure falls back to.
  void commit(const FrameInput& frame) {
    for (const MeshPositions& update : frame.updates)
      std::memcpy(last_good(update.mesh), update.end.data(), update.end.size());
    has_frame_ = true;
    stale_ = false;
  }

  SceneSpec spec_;
  Topology topology_;
  Exec exec_;
  SceneBuffers<Exec, Real> scene_;
  Pipeline<Exec, Real> pipeline_;
  std::vector<std::byte> last_good_;
  bool has_frame_ = false;
  bool stale_ = false;
};

template <class Exec, class... ExecArgs>
std::unique_ptr<Detector> make_scene_detector(SceneSpec spec, FeatureTables features, ExecArgs... args) {
  if (spec.scalar == Scalar::kF64)
    return std::make_unique<SceneDetector<Exec, double>>(std::move(spec), std::move(features), args...);
  return std::make_unique<SceneDetector<Exec, float>>(std::move(spec), std::move(features), args...);
}

}  // namespace collided
