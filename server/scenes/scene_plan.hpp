#pragma once
// A checked request for a scene, in the engine's terms. No gRPC here.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "server/limits/device_bytes.hpp"

namespace collided::server {

/// Maximum bytes of one vertex's positions in a frame: one time (DCD) or two (CCD).
constexpr uint64_t max_vertex_bytes(const SceneSpec& spec) {
  return position_bytes(spec) * (spec.mode == Mode::kDcd ? 1 : 2);
}

inline uint64_t count_vertices(const SceneSpec& spec) {
  uint64_t vertices = 0;
  for (const auto& mesh : spec.meshes) vertices += mesh.vertex_count;
  return vertices;
}

/// Contact fields that the client asked for.
struct OutputFields {
  FieldSet columns;       ///< that the engine makes
  bool stencils = false;  ///< made from the elements

  /// Bytes of one contact's arrays.
  size_t contact_bytes() const { return collided::contact_bytes(columns) + stencil_bytes(); }
  /// Bytes of the one array that the engine does not produce.
  size_t stencil_bytes() const { return stencils ? sizeof(std::array<uint32_t, 4>) : 0; }
};

struct MeshPlan {
  std::string name;
  uint64_t triangles = 0;          ///< of the whole mesh
  uint64_t awaited = 0;            ///< of them, those still to be uploaded
  uint64_t edges = 0, points = 0;  ///< loose ones
};

/// A checked request for a scene.
struct ScenePlan {
  std::string display_name;
  OutputFields fields;
  std::vector<MeshPlan> meshes;
  SceneSpec engine;
  uint64_t min_bytes = 0;                ///< minimum memory of the scene once it has had a frame
  std::shared_ptr<DeviceBytes> quota{};  ///< of its client, around the scene's own budget; may be null
};

/// Bytes that a scene holds of its plan: the plan, its copies until and in the detector, and what else is kept for each
/// mesh.
inline uint64_t plan_bytes(const ScenePlan& plan) {
  constexpr uint64_t kOfMesh = sizeof(MeshPlan) + 3 * sizeof(MeshSpec) + 4 * sizeof(uint64_t);
  constexpr uint64_t kOfPair = sizeof(SceneSpec::excluded_meshes[0]);
  constexpr uint64_t kOfRigidMesh = 512;  // its poses
  uint64_t bytes = plan.meshes.size() * kOfMesh + 3 * plan.engine.excluded_meshes.size() * kOfPair;
  for (const auto& mesh : plan.meshes) bytes += mesh.name.size();
  for (const auto& mesh : plan.engine.meshes) bytes += mesh.motion == MeshMotion::kRigid ? kOfRigidMesh : 0;
  return bytes;
}

}  // namespace collided::server
