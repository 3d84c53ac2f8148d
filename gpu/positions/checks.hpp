#pragma once
// Refuses positions that cannot be used before anything of the scene changes.

#include "gpu/positions/pose.hpp"
#include "gpu/types.hpp"

namespace collided {

/// Throws InvalidInput naming the update that does not fit the meshes, whatever frames were before it. Values are not
/// looked at.
void check_updates(const SceneSpec& spec, const std::vector<MeshPositions>& updates);

/// A mesh that a frame has positions for.
struct SentMesh {
  uint32_t mesh;
  bool is_sparse;
  bool has_positions, has_transform;
};

/// Meshes, each of which has its first positions in this frame.
using FirstMeshes = std::vector<bool>;

/// Throws InvalidInput for what only a mesh's first frame may bring, and for what it has to: all of `first` must be
/// named, and whole.
void check_turn(const SceneSpec& spec, const std::vector<SentMesh>& meshes, const FirstMeshes& first);

/// A rigid mesh that a frame moves.
struct RigidMove {
  size_t update;  ///< its number in the frame
  uint32_t mesh;
  std::optional<Pose> start;  ///< none: where the last frame left the mesh
  Pose end;
};
/// Of updates that check_updates has let pass.
std::vector<RigidMove> moves_of(const std::vector<MeshPositions>& updates);

/// A position: the update's number in the frame, its mesh, and the number in the update.
struct UpdatePlace {
  size_t update;
  std::string mesh;  ///< its name (name_of_mesh)
  uint64_t position;
};
/// "mesh 1"; of a set of worlds "world 3, mesh 1".
std::string name_of_mesh(const SceneSpec& spec, uint32_t mesh);

/// Throws InvalidInput for an index that does not ascend or is not below the mesh's number of vertices.
[[noreturn]] void refuse_index(const UpdatePlace& place, uint32_t index, uint32_t vertex_count);

/// A coordinate (0 to 2) of a vertex of the mesh that is not finite or past the limit.
struct BadCoordinate {
  uint32_t vertex, coordinate;
  double value, limit;
};
/// Throws InvalidInput.
[[noreturn]] void refuse_coordinate(const UpdatePlace& place, bool is_end, const BadCoordinate& bad);

}  // namespace collided
