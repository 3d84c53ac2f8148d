#pragma once
// Reads and writes mesh files: OBJ and PLY (ASCII, binary of either byte order, float or double positions). Loose edges
// and points are read from OBJ; a mesh that has some is not written.

#include <filesystem>
#include <vector>

#include "client/scenes/scene.hpp"

namespace collided::scenes {

struct MeshFile {
  std::vector<Vec3d> positions;
  std::vector<std::array<uint32_t, 3>> triangles;
  bool is_double = false;                           ///< a position is not exactly a float
  std::vector<std::array<uint32_t, 2>> edges = {};  ///< loose ones
  std::vector<uint32_t> points = {};                ///< loose ones
};

/// Reads the format that the file's extension names. Throws std::runtime_error naming the file, the place and the
/// problem.
MeshFile read_mesh(const std::filesystem::path& file);

/// Writes OBJ (17 digits) or binary little-endian double PLY, as the file's extension says.
void write_mesh(const std::filesystem::path& file, const MeshFile& mesh);

}  // namespace collided::scenes
