#pragma once
// Reads mesh files (OBJ, PLY, STL, OFF, glTF, GLB, COLLADA) and writes OBJ and PLY. A mesh with loose edges or points
// is read but not written.

#include <filesystem>
#include <string>
#include <vector>

#include "client/scenes/scene.hpp"

namespace collided::scenes {

/// Faces of three or more corners each. Their corners follow one another.
struct Polygons {
  std::vector<uint32_t> corners;
  std::vector<uint32_t> counts;  ///< corners of each face

  bool operator==(const Polygons&) const = default;
};

struct MeshFile {
  std::vector<Vec3d> positions;
  std::vector<std::array<uint32_t, 3>> triangles;
  bool is_double = false;                           ///< a position is not exactly a float
  std::vector<std::array<uint32_t, 2>> edges = {};  ///< loose ones
  std::vector<uint32_t> points = {};                ///< loose ones
  Polygons polygons = {};                           ///< the faces, if one of them has more than three corners
  std::vector<std::string> notes = {};              ///< sentences on what was welded, joined or dropped
};

/// The formats that read_mesh knows, as a list of extensions for messages and help texts.
inline constexpr char kMeshExtensions[] = ".obj, .ply, .stl, .off, .gltf, .glb or .dae";

/// True if the extension names a format that read_mesh knows.
bool is_mesh_file(const std::filesystem::path& file);

/// Reads the format that the file's extension names. Faces that equal those of `like` are split as they were split
/// there: the frames of a sequence keep their triangles although polygons bend. Throws std::runtime_error naming the
/// file, the place and the problem.
MeshFile read_mesh(const std::filesystem::path& file, const MeshFile* like = nullptr);

/// Writes OBJ (17 digits) or binary little-endian double PLY, as the file's extension says.
void write_mesh(const std::filesystem::path& file, const MeshFile& mesh);

}  // namespace collided::scenes
