// What all streams play, back and forth.

#include "client/measure/load/drive/motion.hpp"

#include <memory>

#include "client/cli/input/step_input.hpp"

namespace collided::cli::load {

namespace {

Motion scene_motion(const InputSettings& input) {
  const std::shared_ptr<const scenes::Scene> scene = scenes::make_scene(input.scene, input.scale);
  const int steps = input.steps;
  return {.name = input.scene,
          .meshes = scene->meshes(),
          .frames = static_cast<size_t>(steps),
          .positions = [scene, steps](size_t frame) { return scene->positions(static_cast<double>(frame) / steps); }};
}

Motion file_motion(const std::vector<std::string>& files) {
  StepInput first = file_frame(files.front());
  const auto all = std::make_shared<std::vector<std::vector<scenes::Vec3d>>>();
  all->push_back(std::move(first.end));
  for (size_t i = 1; i < files.size(); ++i) all->push_back(file_step(files[i - 1], files[i]).end);
  return {.name = std::to_string(files.size()) + " recorded frames from " + files.front(),
          .meshes = std::move(first.meshes),
          .frames = files.size(),
          .positions = [all](size_t frame) { return all->at(frame); }};
}

}  // namespace

Motion make_motion(const InputSettings& input) {
  return input.files.empty() ? scene_motion(input) : file_motion(input.files);
}

size_t place_in_motion(uint64_t n, size_t frames) {
  if (frames < 2) return 0;
  const uint64_t round = 2 * (frames - 1), at = n % round;
  return static_cast<size_t>(at < frames ? at : round - at);
}

}  // namespace collided::cli::load
