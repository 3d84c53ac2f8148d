// One step of a procedural scene or between two mesh files.

#include "client/cli/input/step_input.hpp"

#include <filesystem>
#include <utility>

#include "client/cli/input/frame_files.hpp"
#include "client/cli/input/mesh_input.hpp"
#include "client/cli/report/numbers.hpp"

namespace collided::cli {

namespace {

std::string stem(const std::string& file) { return std::filesystem::path(file).stem().string(); }

}  // namespace

StepInput scene_step(const SceneOptions& options) {
  const auto scene = scenes::make_scene(options.name, options.scale);
  const double t0 = options.time(0), t1 = options.time(1);
  return {.name = options.name,
          .description = "scene " + options.name + ", scale " + format_double("%g", options.scale) + ", t " +
                         format_double("%g", t0) + " to " + format_double("%g", t1),
          .meshes = scene->meshes(),
          .start = scene->positions(t0),
          .end = scene->positions(t1),
          .is_double = true};
}

StepInput file_step(const std::string& first, const std::string& second) {
  FileFrame a = read_frame(first), b = read_frame(second, a.mesh, first);
  return {.name = stem(first) + " to " + stem(second),
          .description = "frames " + first + " and " + second,
          .meshes = {std::move(a.mesh)},
          .start = std::move(a.positions),
          .end = std::move(b.positions),
          .is_double = a.is_double || b.is_double};
}

StepInput file_frame(const std::string& file) {
  FileFrame frame = read_frame(file);
  return {.name = stem(file),
          .description = "frame " + file,
          .meshes = {std::move(frame.mesh)},
          .start = {},
          .end = std::move(frame.positions),
          .is_double = frame.is_double};
}

v1::Frame step_frame(const StepInput& step, uint64_t id, const v1::SceneSpec& spec) {
  return make_frame(step.meshes, id, spec, step.end, step.start);
}

}  // namespace collided::cli
