// What all streams play, back and forth.

#include "client/measure/load/drive/motion.hpp"

#include <memory>

#include "client/app/input/frame_files.hpp"

namespace collided::cli::load {

namespace {

Motion motion_of_scene(const InputSettings& input) {
  const std::shared_ptr<const scenes::Scene> scene = scenes::make_scene(input.scene, input.scale);
  const int steps = input.steps;
  return {.name = input.scene,
          .meshes = scene->meshes(),
          .frames = steps,
          .files = {},
          .positions = [scene, steps](int frame) { return scene->positions(static_cast<double>(frame) / steps); }};
}

Motion motion_of_files(std::vector<std::string> files) {
  files = expand_folders(files);
  sort_naturally(files);
  FileFrame first = read_frame(files.front());
  const auto all = std::make_shared<std::vector<std::vector<scenes::Vec3d>>>();
  all->push_back(first.positions);
  for (size_t i = 1; i < files.size(); ++i) all->push_back(read_frame(files[i], first, files.front()).positions);
  return {.name = std::to_string(files.size()) + " recorded frames from " + files.front(),
          .meshes = {std::move(first.mesh)},
          .frames = static_cast<int>(files.size()),
          .files = files,
          .positions = [all](int frame) { return all->at(static_cast<size_t>(frame)); }};
}

}  // namespace

Motion make_motion(const InputSettings& input) {
  return input.files.empty() ? motion_of_scene(input) : motion_of_files(input.files);
}

size_t place_in_motion(uint64_t n, size_t frames) {
  if (frames < 2) return 0;
  const uint64_t round = 2 * (frames - 1), at = n % round;
  return static_cast<size_t>(at < frames ? at : round - at);
}

}  // namespace collided::cli::load
