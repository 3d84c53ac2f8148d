#pragma once
// Options for the procedural scene that a subcommand plays, and for a daemon's scene.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <stdexcept>
#include <string>

#include "client/app/options/finite.hpp"
#include "client/app/options/values.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// Refuses, before anything is done, a procedural scene that there is not.
inline CLI::Validator known_scene() {
  const auto check = [](const std::string& word) -> std::string {
    try {
      scenes::check_scene(word, 1);
      return "";
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
  };
  return CLI::Validator(check, "");
}

/// Refuses what no daemon calls a scene, and no message could carry.
inline CLI::Validator scene_id() {
  const auto check = [](const std::string& word) {
    const bool is_visible = std::all_of(word.begin(), word.end(), [](char c) { return c > ' ' && c <= '~'; });
    return is_visible ? std::string() : "the id has a character that is not visible ASCII, which none has";
  };
  return CLI::Validator(check, "");
}

inline void add_scale_option(CLI::App& command, double& scale) {
  command.add_option("--scale", scale, "Refines the grids: triangles grow by about its square")->capture_default_str();
}

inline void add_scene_options(CLI::App& command, SceneOptions& options) {
  command.add_option("--scene", options.name, "Name of the scene, see 'collidectl scenes'")
      ->type_name("SCENE")
      ->check(known_scene())
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
