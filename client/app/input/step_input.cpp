// One step of a procedural scene or between two mesh files.

#include "client/app/input/step_input.hpp"

#include <filesystem>
#include <map>
#include <utility>

#include "client/app/input/frame_files.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/app/report/numbers.hpp"
#include "client/app/report/text.hpp"

namespace collided::cli {

namespace {

constexpr size_t kMaxNameBytes = 100;  // MeshSpec.name, less a number

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
  FileFrame a = read_frame(first), b = read_frame(second, a, first);
  std::vector<std::string> notes = a.notes;
  notes.insert(notes.end(), b.notes.begin(), b.notes.end());
  return {.name = stem(first) + " to " + stem(second),
          .description = "frames " + first + " and " + second,
          .meshes = {std::move(a.mesh)},
          .start = std::move(a.positions),
          .end = std::move(b.positions),
          .is_double = a.is_double || b.is_double,
          .notes = std::move(notes)};
}

StepInput file_frame(const std::string& file) {
  FileFrame frame = read_frame(file);
  return {.name = stem(file),
          .description = "frame " + file,
          .meshes = {std::move(frame.mesh)},
          .start = {},
          .end = std::move(frame.positions),
          .is_double = frame.is_double,
          .notes = std::move(frame.notes)};
}

StepInput file_meshes(const std::vector<std::string>& files) {
  StepInput out;
  std::map<std::string, int> taken;
  for (const std::string& file : files) {
    FileFrame frame = read_frame(file);
    frame.mesh.name = shown_name(stem(file)).substr(0, kMaxNameBytes);
    if (const int number = ++taken[frame.mesh.name]; number > 1) frame.mesh.name += " (" + std::to_string(number) + ")";
    out.name += (out.name.empty() ? "" : ", ") + frame.mesh.name;
    out.description += (out.description.empty() ? "meshes " : ", ") + file;
    out.meshes.push_back(std::move(frame.mesh));
    out.end.insert(out.end.end(), frame.positions.begin(), frame.positions.end());
    out.is_double = out.is_double || frame.is_double;
    out.notes.insert(out.notes.end(), frame.notes.begin(), frame.notes.end());
  }
  return out;
}

v1::Frame step_frame(const StepInput& step, uint64_t id, const v1::SceneSpec& spec) {
  return make_frame(step.meshes, id, spec, step.end, step.start);
}

}  // namespace collided::cli
