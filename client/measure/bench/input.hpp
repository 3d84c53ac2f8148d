#pragma once
// What 'collidectl bench' plays, and in which order.

#include <functional>
#include <string>
#include <vector>

#include "client/cpp/client.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// Meshes, and a motion of `steps` steps that are counted from 1.
struct BenchInput {
  using PositionsOf = std::function<std::vector<scenes::Vec3d>(int step, int steps)>;
  std::string name;
  std::vector<scenes::Mesh> meshes;
  PositionsOf start, end;  ///< of a step, of all meshes in their order
  bool is_motion = true;   ///< a step starts where the one before it ended
};

/// A procedural scene from t = 0 to t = 1. Throws std::invalid_argument if there is none of that name and scale.
BenchInput scene_input(const std::string& name, double scale);
/// The step between two mesh files, or the one frame (DCD), again and again. Throws std::runtime_error naming the file.
BenchInput file_input(const std::vector<std::string>& files);

/// The steps of the warm-up, then all of them in order. Those of the warm-up are spread evenly over the motion and end
/// with its last, so that buffers have grown to about what the motion needs.
std::vector<int> planned_steps(int steps, int warm_up);

/// Frame `at` (from 0) of a plan. A CCD frame tells where it starts if it does not go on from the one before it.
v1::Frame planned_frame(const BenchInput& input, const std::vector<int>& plan, size_t at, int steps,
                        const v1::SceneSpec& spec);

}  // namespace collided::cli
