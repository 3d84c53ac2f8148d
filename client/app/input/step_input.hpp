#pragma once
// One step: meshes with their positions at its start and at its end.

#include <string>
#include <vector>

#include "client/app/options/values.hpp"
#include "client/cpp/client.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

struct StepInput {
  std::string name, description;
  std::vector<scenes::Mesh> meshes;
  std::vector<scenes::Vec3d> start, end;  ///< of all meshes, in their order; a single frame has no start
  bool is_double = false;                 ///< a position is not exactly a float
  std::vector<std::string> notes = {};    ///< what the reader changed in the files
};

/// The step of a procedural scene from t0 to t0 + dt.
StepInput scene_step(const SceneOptions& options);
/// The step between two mesh files. Throws std::runtime_error if they differ in more than positions.
StepInput file_step(const std::string& first, const std::string& second);
/// The frame in a mesh file.
StepInput file_frame(const std::string& file);
/// Meshes that stand still, one a file, named after the files.
StepInput file_meshes(const std::vector<std::string>& files);

/// The whole step in one frame; the frame of id 1 has the static meshes as well.
v1::Frame step_frame(const StepInput& step, uint64_t id, const v1::SceneSpec& spec);

}  // namespace collided::cli
