#pragma once
// A checked request for a scene, in the engine's terms. No gRPC here.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "server/devices/device_bytes.hpp"
#include "server/devices/served_devices.hpp"

namespace collided::server {

using TriangleCorners = std::array<uint32_t, 3>;

/// Of a mesh or a scene.
constexpr size_t kMaxNameBytes = 128;

/// Maximum bytes of one vertex's positions in a frame: one time (DCD) or two (CCD).
constexpr uint64_t max_vertex_bytes(const SceneSpec& spec) {
  return position_bytes(spec) * (spec.mode == Mode::kDcd ? 1 : 2);
}

/// Of each world of a set.
inline uint64_t count_vertices(const SceneSpec& spec) {
  uint64_t vertices = 0;
  for (const auto& mesh : spec.meshes) vertices += mesh.vertex_count;
  return vertices;
}

/// Maximum bytes of positions in a frame, of all worlds.
inline uint64_t max_position_bytes(const SceneSpec& spec) {
  return count_worlds(spec) * count_vertices(spec) * max_vertex_bytes(spec);
}

/// Returns true for a scene that is spread over devices, or several times over one.
inline bool is_sharded(const SceneSpec& spec) { return !spec.part_devices.empty(); }

/// Returns all devices that a scene is on, each once, in order.
std::vector<Device> devices_of(const SceneSpec& spec);

/// Fields of answers that the client asked for.
struct OutputFields {
  FieldSet columns;          ///< that the engine makes
  bool stencils = false;     ///< made from the elements
  bool worlds = false;       ///< of a set: made from where each world's contacts begin
  bool pair_states = false;  ///< of pairs of meshes, not of contacts

  /// Bytes of one contact's arrays.
  size_t contact_bytes() const { return collided::contact_bytes(columns) + made_bytes(); }
  /// Bytes of those that the engine does not produce.
  size_t made_bytes() const {
    return (stencils ? sizeof(std::array<uint32_t, 4>) : 0) + (worlds ? sizeof(uint32_t) : 0);
  }
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
  std::optional<Device> device{};  ///< that its client asks for
  uint64_t min_bytes = 0;          ///< minimum memory of the scene once it has had a frame
  std::shared_ptr<DeviceBytes>
      quota{};  ///< around the scene's own budget: its client's, within its device's once placed
  std::vector<std::shared_ptr<DeviceBytes>> shards{};  ///< as Placement has them; then `quota` is the client's alone
};

/// Which devices may have the scene.
inline DeviceWish wish_of(const ScenePlan& plan) {
  const std::vector<Device>& shards = plan.engine.part_devices;
  return {plan.engine.device.backend, shards.empty() ? plan.device : shards.front(), shards, plan.min_bytes,
          plan.quota};
}

/// Copies a plan without the elements of its meshes, which may be many; they stay where they are.
ScenePlan without_elements(ScenePlan& plan);

/// The quotas of all memory that a scene holds, within its budget, its client's limits and its devices'.
struct SceneQuota {
  explicit SceneQuota(const ScenePlan& plan);

  std::shared_ptr<DeviceBytes> whole;      ///< of a sharded scene, of what is the scene's as a whole
  std::shared_ptr<MemoryQuota> of_engine;  ///< sharded, if the scene is; else the same
};

/// A mesh that an edit brings.
struct EditedMesh {
  uint32_t mesh = 0;
  std::string name;             ///< empty: as before
  bool keeps_elements = false;  ///< it has those that it had
  uint64_t triangles = 0, edges = 0, points = 0;
};

/// What a frame was checked against when it came.
struct FrameBasis {
  std::shared_ptr<const ScenePlan> plan;  ///< null: whatever the scene's is
  std::vector<EditedMesh> edited;         ///< of the frame's edit
};

/// The plan after an edit that made this of the engine's scene.
ScenePlan edited_plan(const ScenePlan& before, const std::vector<EditedMesh>& edited, const SceneSpec& engine);

// Of one mesh, of one pair that is excluded, and of the poses of a rigid mesh, in all copies.
constexpr uint64_t kMeshBytes = sizeof(MeshPlan) + 4 * sizeof(MeshSpec) + 4 * sizeof(uint64_t);
constexpr uint64_t kPairBytes = 4 * sizeof(std::array<uint32_t, 2>);
constexpr uint64_t kPoseBytes = 512;
// Of a mesh in one world of a set: its first vertex, its place in frames in flight.
constexpr uint64_t kMeshOfWorldBytes = 256;

/// Bytes that a scene holds of its plan: the plan, its copies until and in the detector, and what else is kept for each
/// mesh.
inline uint64_t plan_bytes(const ScenePlan& plan) {
  uint64_t bytes = plan.meshes.size() * kMeshBytes + plan.engine.excluded_meshes.size() * kPairBytes;
  bytes += uint64_t{plan.engine.worlds} * plan.meshes.size() * kMeshOfWorldBytes;
  for (const auto& mesh : plan.meshes) bytes += mesh.name.size();
  for (const auto& mesh : plan.engine.meshes) bytes += mesh.motion == MeshMotion::kRigid ? kPoseBytes : 0;
  return bytes;
}

/// Copies of the topology that a scene has on the host: each shard has its own.
inline uint64_t count_tables(const SceneSpec& spec) { return std::max<uint64_t>(spec.part_devices.size(), 1); }

/// Of the scene's tables on the host.
inline uint64_t topology_bytes(const Topology& topology) {
  return topology.triangles.capacity() * sizeof(topology.triangles[0]) +
         topology.edges.capacity() * sizeof(topology.edges[0]);
}

/// By which an edit adds to either, at most.
uint64_t max_edit_bytes(const SceneEdit& edit);

}  // namespace collided::server
