#pragma once
// What all streams play, back and forth: a procedural scene, or recorded frames.

#include <functional>
#include <string>
#include <vector>

#include "client/measure/load/settings.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli::load {

struct Motion {
  std::string name;
  std::vector<scenes::Mesh> meshes;
  size_t frames = 0;  ///< 1 or more
  std::function<std::vector<scenes::Vec3d>(size_t frame)> positions;
};

/// Reads the files. Throws std::invalid_argument or std::runtime_error naming what is wrong.
Motion make_motion(const InputSettings& input);

/// Which of `frames` frames the `n`-th frame of a stream is, both from 0: first forth, then back, so that no mesh
/// jumps.
size_t place_in_motion(uint64_t n, size_t frames);

}  // namespace collided::cli::load
