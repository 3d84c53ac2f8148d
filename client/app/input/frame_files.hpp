#pragma once
// Mesh files: frames, one a file, and the frames in a folder.

#include <string>
#include <vector>

#include "client/scenes/mesh_files/mesh_file.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// A frame in a file: its only mesh, named "mesh", and the positions.
struct FileFrame {
  scenes::Mesh mesh;
  std::vector<scenes::Vec3d> positions;
  bool is_double = false;               ///< a position is not exactly a float
  scenes::Polygons polygons = {};       ///< the faces as the file has them, if some are no triangles
  std::vector<std::string> notes = {};  ///< what the reader welded, joined or dropped, with the file's name
};

/// Throws std::runtime_error naming the file and what is wrong with it.
FileFrame read_frame(const std::string& file);
/// The same of a later frame. Throws std::runtime_error naming both files if they differ in more than positions.
FileFrame read_frame(const std::string& file, const FileFrame& first, const std::string& first_file);

/// The names, with each folder replaced by the mesh files in it, in natural order. Throws std::runtime_error for a
/// folder without any.
std::vector<std::string> expand_folders(const std::vector<std::string>& names);

/// Sorts names by the numbers in them: frame2 before frame10.
void sort_naturally(std::vector<std::string>& names);

}  // namespace collided::cli
