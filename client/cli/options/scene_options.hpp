#pragma once
// Options for the procedural scene that a subcommand plays.

#include <CLI/CLI.hpp>

#include "client/cli/options/finite.hpp"
#include "client/cli/options/values.hpp"

namespace collided::cli {

inline void add_scale_option(CLI::App& command, double& scale) {
  command.add_option("--scale", scale, "Refines the grids: triangles grow by about its square")->capture_default_str();
}

inline void add_scene_options(CLI::App& command, SceneOptions& options) {
  command.add_option("--scene", options.name, "Name of the scene, see 'collidectl scenes'")
      ->type_name("SCENE")
      ->required();
  command.add_option("--frames", options.frames, "Number of frames")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command.add_option("--t0", options.t0, "Time of the first frame; a scene goes from 0 to 1")
      ->check(finite())
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command.add_option("--dt", options.dt, "Time from one frame to the next")
      ->check(finite())
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  add_scale_option(command, options.scale);
}

/// For subcommands that play mesh files instead, if no scene is named.
inline void add_optional_scene_options(CLI::App& command, SceneOptions& options) {
  add_scene_options(command, options);
  CLI::Option* scene = command.get_option("--scene")->required(false);
  for (const char* of_scenes : {"--frames", "--t0", "--dt", "--scale"}) command.get_option(of_scenes)->needs(scene);
}

}  // namespace collided::cli
