#pragma once
// The procedural scene that a subcommand plays.

#include <CLI/CLI.hpp>
#include <string>

namespace collided::cli {

struct SceneOptions {
  std::string name;
  double scale = 1;
  int frames = 60;

  /// Time of a frame: the first is at `first`, the last at 1.
  double time(int frame, double first = 0) const {
    return frames == 1 ? first : first + (1 - first) * frame / (frames - 1);
  }
};

inline void add_scene_options(CLI::App& command, SceneOptions& options) {
  command.add_option("--scene", options.name, "Name of the scene, see 'collidectl scenes'")->required();
  command.add_option("--frames", options.frames, "Number of frames")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command.add_option("--scale", options.scale, "Refines the grids: triangles grow by about its square")
      ->capture_default_str();
}

}  // namespace collided::cli
