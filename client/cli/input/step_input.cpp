// One step of a procedural scene or between two mesh files.

#include "client/cli/input/step_input.hpp"

#include <filesystem>
#include <stdexcept>

#include "client/cli/input/mesh_input.hpp"
#include "client/cli/report/numbers.hpp"
#include "client/scenes/mesh_files/mesh_file.hpp"

namespace collided::cli {

namespace {

void check_same(const std::string& what, size_t a, size_t b) {
  if (a != b)
    throw std::runtime_error("the frames differ: the first has " + std::to_string(a) + " " + what + ", the second " +
                             std::to_string(b));
}

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
  scenes::MeshFile a = scenes::read_mesh(first), b = scenes::read_mesh(second);
  check_same("vertices", a.positions.size(), b.positions.size());
  check_same("triangles", a.triangles.size(), b.triangles.size());
  for (size_t t = 0; t < a.triangles.size(); ++t)
    if (a.triangles[t] != b.triangles[t])
      throw std::runtime_error("the frames differ: triangle " + std::to_string(t) + " has other vertices in " + second);
  if (a.edges != b.edges || a.points != b.points)
    throw std::runtime_error("the frames differ: " + second + " has other loose edges or points than the first");
  const auto vertex_count = static_cast<uint32_t>(a.positions.size());
  return {.name = stem(first) + " to " + stem(second),
          .description = "frames " + first + " and " + second,
          .meshes = {{"mesh", vertex_count, std::move(a.triangles), false, std::move(a.edges), std::move(a.points)}},
          .start = std::move(a.positions),
          .end = std::move(b.positions),
          .is_double = a.is_double || b.is_double};
}

StepInput file_frame(const std::string& file) {
  scenes::MeshFile mesh = scenes::read_mesh(file);
  const auto vertex_count = static_cast<uint32_t>(mesh.positions.size());
  return {.name = stem(file),
          .description = "frame " + file,
          .meshes = {{"mesh", vertex_count, std::move(mesh.triangles), false, std::move(mesh.edges),
                      std::move(mesh.points)}},
          .start = {},
          .end = std::move(mesh.positions),
          .is_double = mesh.is_double};
}

v1::Frame step_frame(const StepInput& step, uint64_t id, const v1::SceneSpec& spec) {
  return make_frame(step.meshes, id, spec, step.end, step.start);
}

}  // namespace collided::cli
