#pragma once
// The inputs that 'collidectl bench' plays, and their order.

#include <functional>
#include <string>
#include <vector>

#include "client/cpp/client.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// Meshes and their motion in `steps` steps, counted from 1.
struct BenchInput {
  using PositionsOf = std::function<std::vector<scenes::Vec3d>(int step, int steps)>;
  std::string name;
  std::vector<scenes::Mesh> meshes;
  PositionsOf start, end;  ///< of a step: positions of all meshes, in their order
  bool is_motion = true;   ///< each step starts where the previous one ended
};

/// A procedural scene from t = 0 to t = 1. Throws std::invalid_argument for an unknown name or a bad scale.
BenchInput scene_input(const std::string& name, double scale);
/// The step between two mesh files, or one frame (DCD), repeated. Throws std::runtime_error naming the file.
BenchInput file_input(const std::vector<std::string>& files);

/// Makes room for all steps in the box that positions are encoded in; nothing for a format without one.
void grow_box(v1::SceneSpec& spec, const BenchInput& input, int steps);

/// The steps of the warm-up, then all steps in order. The warm-up is spread evenly over the motion and ends with its
/// last step, so that buffers grow to about what the motion needs.
std::vector<int> planned_steps(int steps, int warm_up);

/// Frame `at`, counted from 0, of a plan. A CCD frame has start positions unless it continues the previous frame.
v1::Frame planned_frame(const BenchInput& input, const std::vector<int>& plan, size_t at, int steps,
                        const v1::SceneSpec& spec);

}  // namespace collided::cli
