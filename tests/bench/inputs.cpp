#include "tests/bench/inputs.hpp"

#include <algorithm>

#include "tests/support/frames/real_frames.hpp"

namespace collided::test {
namespace {

BenchInput procedural(const std::string& name, double scale, double seconds) {
  std::shared_ptr<scenes::Scene> scene = scenes::make_scene(name, scale);
  return {name, [scene, seconds](int step, int steps) {
            const double t = (step + 1.0) / steps;
            return case_of(*scene, std::max(0.0, t - seconds), t);
          }};
}

BenchInput real(const RealFrames& frames) {
  auto loaded = std::make_shared<Case>(load(frames));
  return {frames.name, [loaded](int, int) { return *loaded; }};
}

}  // namespace

FrameInput moved_to_slot(const FrameInput& frame, FrameSlot& slot) {
  uint64_t bytes = 0;
  for (const MeshPositions& update : frame.updates) bytes += update.start.size() + update.end.size();
  std::span<std::byte> room = slot.room(bytes);
  const auto move = [&](std::span<const std::byte>& values) {
    std::copy(values.begin(), values.end(), room.begin());
    values = std::exchange(room, room.subspan(values.size())).first(values.size());
  };
  FrameInput moved = frame;
  for (MeshPositions& update : moved.updates) {
    move(update.start);
    move(update.end);
  }
  return moved;
}

std::vector<BenchInput> bench_inputs(const std::string& only, double scale, double seconds) {
  std::vector<BenchInput> inputs;
  for (const std::string& name : only.empty() ? scene_names() : std::vector{only})
    if (is_procedural(name)) inputs.push_back(procedural(name, scale, seconds));
  for (const RealFrames& frames : frames_of_data_folder())
    if (only.empty() || only == frames.name) inputs.push_back(real(frames));
  return inputs;
}

}  // namespace collided::test
