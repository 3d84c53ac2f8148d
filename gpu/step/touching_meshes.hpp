#pragma once
// Two meshes all of whose common points are ties: whether they overlap all the same. It runs on the host.

#include <unordered_map>
#include <vector>

#include "gpu/base/keys.hpp"
#include "gpu/exact/overlap.hpp"
#include "gpu/step/pair_states.hpp"

namespace collided {

/// Holds a mesh with its vertices where they are.
class MeshOnHost {
 public:
  /// read(first vertex, count): the positions of a run of vertices.
  template <class Read>
  MeshOnHost(const SolidMeshes& meshes, uint32_t mesh, const Read& read) {
    const Topology& topology = *meshes.topology;
    first_vertex_ = topology.vertex_offset[mesh];
    points_ = read(first_vertex_, topology.vertex_offset[mesh + 1] - first_vertex_);
    for (uint32_t i = 0; i < points_.size(); ++i) ids_.push_back(first_vertex_ + i);
    for (uint32_t i = topology.triangle_offset[mesh]; i < topology.triangle_offset[mesh + 1]; ++i) {
      const auto& t = topology.triangles[i];
      triangles_.push_back({t[0] - first_vertex_, t[1] - first_vertex_, t[2] - first_vertex_});
    }
  }

  SolidMesh solid() const { return {points_, ids_, triangles_}; }
  const std::vector<std::array<uint32_t, 3>>& triangles() const { return triangles_; }
  uint32_t first_vertex() const { return first_vertex_; }
  void corners_of(const std::array<uint32_t, 3>& triangle, Vec3<double> (&corners)[3]) const {
    for (size_t k = 0; k < 3; ++k) corners[k] = points_[triangle[k]];
  }

 private:
  uint32_t first_vertex_;
  std::vector<Vec3<double>> points_;
  std::vector<uint32_t> ids_;
  std::vector<std::array<uint32_t, 3>> triangles_;  ///< counted in the mesh
};

/// Returns whether triangles of two meshes go through each other. `ties`: edges and triangles of any meshes that meet.
/// The ends of a segment in which two triangles go through each other are such ties of theirs.
bool triangles_go_through(const SolidMeshes& meshes, const std::vector<EdgeAndTriangle>& ties, uint32_t first,
                          uint32_t second, const MeshOnHost& of_first, const MeshOnHost& of_second);

}  // namespace collided
