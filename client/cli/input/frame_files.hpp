#pragma once
// Frames in mesh files, one a file.

#include <string>
#include <vector>

#include "client/scenes/scene.hpp"

namespace collided::cli {

/// A frame in a file: its only mesh, named "mesh", and the positions.
struct FileFrame {
  scenes::Mesh mesh;
  std::vector<scenes::Vec3d> positions;
  bool is_double = false;  ///< a position is not exactly a float
};

/// Throws std::runtime_error naming the file and what is wrong with it.
FileFrame read_frame(const std::string& file);
/// The same of a later frame. Throws std::runtime_error naming both files if they differ in more than positions.
FileFrame read_frame(const std::string& file, const scenes::Mesh& first, const std::string& first_file);

/// Sorts names by the numbers in them: frame2 before frame10.
void sort_naturally(std::vector<std::string>& names);

}  // namespace collided::cli
