#pragma once
// The meshes of a scene, and their elements, from the protocol to the engine.

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "collided/v1/scene.pb.h"
#include "server/config/config.hpp"
#include "server/scenes/scene/plan.hpp"

namespace collided::server {

namespace pb = collided::v1;

/// Meshes of one scene. With the longest names such a scene still fits one message of gRPC's default size.
constexpr int kMaxMeshes = 16384;

/// Names triangles in messages.
struct TrianglePath {
  std::string field;
  uint64_t first = 0;  ///< number of triangles before these
};

/// Checks each triangle of a packed uint32[n][3] array and hands it to `take`. Throws InvalidInput.
void for_each_triangle(std::string_view bytes, uint32_t vertex_count, const TrianglePath& path,
                       const std::function<void(const TriangleCorners&)>& take);

struct SceneSize {
  uint64_t vertices = 0, triangles = 0;
  uint64_t loose = 0;  ///< edges and points

  uint64_t elements() const { return triangles + loose; }
  const char* names_of_elements() const { return loose == 0 ? "triangles" : "triangles, edges and points"; }
};

/// Sums up the meshes before any array is copied. Throws InvalidInput without a mesh, LimitExceeded.
SceneSize check_sizes(const pb::SceneSpec& spec, const Limits& limits);

/// Throws InvalidInput for a name that no mesh can have.
void check_mesh_name(const std::string& name, const std::string& path);
/// A mesh but for its name, with the elements that the message has. Throws InvalidInput.
MeshSpec parse_mesh(const pb::MeshSpec& mesh, const std::string& path);
/// Throws LimitExceeded, naming the field, where a scene's meshes are too many or too large.
void check_sizes(size_t meshes, const SceneSize& size, const Limits& limits, const std::string& field);

/// Adds the meshes to the plan. Throws InvalidInput.
void parse_meshes(const pb::SceneSpec& spec, ScenePlan& plan);
/// Adds which pairs are left out, after the meshes. Throws InvalidInput.
void parse_exclusions(const pb::SceneSpec& spec, ScenePlan& plan);

}  // namespace collided::server
