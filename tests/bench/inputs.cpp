#include "tests/bench/inputs.hpp"

#include <algorithm>

#include "tests/support/frames/real_frames.hpp"

namespace collided::test {
namespace {

BenchInput procedural(const std::string& name, double scale) {
  std::shared_ptr<scenes::Scene> scene = scenes::make_scene(name, scale);
  return {name, [scene](int step, int steps) {
            const double t = (step + 1.0) / steps;
            return case_of(*scene, std::max(0.0, t - 1.0 / 60), t);
          }};
}

BenchInput real(const RealFrames& frames) {
  auto loaded = std::make_shared<Case>(load(frames));
  return {frames.name, [loaded](int, int) { return *loaded; }};
}

}  // namespace

std::vector<BenchInput> bench_inputs(const std::string& only, double scale) {
  std::vector<BenchInput> inputs;
  for (const scenes::SceneInfo& info : scenes::list_scenes())
    if (only.empty() || only == info.name) inputs.push_back(procedural(info.name, scale));
  for (const scenes::SceneInfo& info : scenes::list_variants())
    if (only == info.name) inputs.push_back(procedural(info.name, scale));
  for (const RealFrames& frames : {kFunnelFrames, kBallFrames})
    if (are_here(frames) && (only.empty() || only == frames.name)) inputs.push_back(real(frames));
  return inputs;
}

}  // namespace collided::test
