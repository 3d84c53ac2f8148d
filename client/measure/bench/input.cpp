// The inputs that 'collidectl bench' plays, and their order.

#include "client/measure/bench/input.hpp"

#include <memory>

#include "client/app/input/mesh_input.hpp"
#include "client/app/input/step_input.hpp"
#include "client/cpp/positions.hpp"

namespace collided::cli {

BenchInput scene_input(const std::string& name, double scale) {
  const std::shared_ptr<const scenes::Scene> scene = scenes::make_scene(name, scale);
  const auto after = [scene](int step, int steps) { return scene->positions(static_cast<double>(step) / steps); };
  const auto before = [after](int step, int steps) { return after(step - 1, steps); };
  return {.name = name, .meshes = scene->meshes(), .start = before, .end = after};
}

BenchInput file_input(const std::vector<std::string>& files) {
  const auto step = std::make_shared<const StepInput>(files.size() == 1 ? file_frame(files[0])  //
                                                                        : file_step(files[0], files[1]));
  return {.name = step->name,
          .meshes = step->meshes,
          .start = [step](int, int) { return step->start; },
          .end = [step](int, int) { return step->end; },
          .is_motion = false};
}

void grow_box(v1::SceneSpec& spec, const BenchInput& input, int steps) {
  if (!client::is_quantized(spec.position_format())) return;
  if (spec.mode() == v1::DETECTION_MODE_CCD) grow_box(spec, input.start(1, steps));
  for (int step = 1; step <= steps; ++step) grow_box(spec, input.end(step, steps));
}

std::vector<int> planned_steps(int steps, int warm_up) {
  std::vector<int> plan;
  for (int64_t i = 1; i <= warm_up; ++i) plan.push_back(static_cast<int>((i * steps + warm_up - 1) / warm_up));
  for (int step = 1; step <= steps; ++step) plan.push_back(step);
  return plan;
}

v1::Frame planned_frame(const BenchInput& input, const std::vector<int>& plan, size_t at, int steps,
                        const v1::SceneSpec& spec) {
  const int step = plan[at];
  const bool continues = input.is_motion && at > 0 && plan[at - 1] + 1 == step;
  std::vector<scenes::Vec3d> start;
  if (spec.mode() == v1::DETECTION_MODE_CCD && !continues) start = input.start(step, steps);
  return make_frame(input.meshes, at + 1, spec, input.end(step, steps), start);
}

}  // namespace collided::cli
