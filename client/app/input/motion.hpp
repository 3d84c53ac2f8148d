#pragma once
// Frames to play, one after the other: of a procedural scene, or in mesh files.

#include <functional>
#include <string>
#include <vector>

#include "client/app/options/values.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

struct Motion {
  std::string name;
  std::vector<scenes::Mesh> meshes;
  int frames = 0;
  std::vector<std::string> files;                                  ///< of the frames; none of a procedural scene
  bool is_double = false;                                          ///< a position in a file is not exactly a float
  std::vector<std::string> notes = {};                             ///< what the reader changed in the first file
  std::function<std::vector<scenes::Vec3d>(int frame)> positions;  ///< of all meshes; frames count from 0
};

/// Makes room for all frames in the box that positions are encoded in; nothing for a format without one.
void grow_box(v1::SceneSpec& spec, const Motion& motion);

Motion scene_motion(const SceneOptions& options);

/// Frames in mesh files and in folders of them, in their natural order. All are read once, so that one that does not
/// fit is found before the work, and again as they are played. Throws std::runtime_error naming the file, and
/// Interrupted.
Motion file_motion(std::vector<std::string> files);

}  // namespace collided::cli
