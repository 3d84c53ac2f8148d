#pragma once
// Solids have a volume above 0 in the first frame that they are in. Later frames may turn them inside out.

#include <string>
#include <vector>

#include "gpu/exact/poll.hpp"
#include "gpu/exact/volumes.hpp"
#include "gpu/scene/scene_model.hpp"

namespace collided {

template <Executor Exec, class Real>
class SolidVolumes {
 public:
  SolidVolumes(Exec& exec, const SceneModel<Exec, Real>& model, const SceneBuffers<Exec, Real>& scene)
      : exec_(exec), model_(model), scene_(scene) {
    for (const MeshSpec& mesh : model.spec().meshes) are_due_.push_back(mesh.solid);
  }

  /// These solids are of the edit whose frame is in work.
  void expect(std::vector<bool> new_solids) { are_due_ = std::move(new_solids); }
  /// Those that were due have a volume, or there is no such edit any more.
  void settle() { are_due_.clear(); }

  /// Throws InvalidInput for a solid that has none where its vertices are resident now.
  void check() {
    for (uint32_t mesh = 0; mesh < are_due_.size(); ++mesh)
      if (are_due_[mesh]) check(mesh);
  }

 private:
  void check(uint32_t mesh) {
    const Topology& topology = model_.topology();
    const uint32_t first_vertex = topology.vertex_offset[mesh], first = topology.triangle_offset[mesh];
    std::vector<Vec3<Real>> positions(topology.vertex_offset[mesh + 1] - first_vertex);
    MemoryHold held(model_.spec().memory_quota);
    held.resize(positions.size() * sizeof(positions[0]));
    exec_.download(positions.data(), scene_.end.data() + first_vertex, positions.size() * sizeof(positions[0]));
    const exact::PollScope poll([&] { exec_.asks().ask(); });
    const int sign = sign_of_volume({topology.triangles.data() + first, topology.triangle_offset[mesh + 1] - first},
                                    [&](uint32_t v) { return convert<double>(positions[v - first_vertex]); });
    if (sign > 0) return;
    const std::string field = "meshes[" + std::to_string(mesh) + "].solid";
    throw InvalidInput(field, field + " is on, but in its first frame the mesh " +
                                  (sign < 0 ? "is inside out: reverse its triangles" : "has the volume 0"));
  }

  Exec& exec_;
  const SceneModel<Exec, Real>& model_;
  const SceneBuffers<Exec, Real>& scene_;
  std::vector<bool> are_due_;  ///< of each mesh; empty: none
};

}  // namespace collided
