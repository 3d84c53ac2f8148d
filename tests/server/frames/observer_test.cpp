// What an answered frame adds to the metrics.
#include "server/frames/observer.hpp"

#include <gtest/gtest.h>

#include "tests/server/scenes/tiny_scene.hpp"

namespace collided::server {
namespace {

double value_of(const std::string& text, const std::string& name) {
  const auto at = ("\n" + text).find("\n" + name + " ");
  return at == std::string::npos ? -1 : std::stod(text.substr(at + name.size() + 1));
}

// A frame whose step ran twice, and decided something in exact arithmetic after it.
AnsweredFrame frame_with_a_replay() {
  AnsweredFrame frame;
  frame.result.stages = {{"upload", 1}, {"boxes", 2},    {"pairs", 4}, {"boxes", 2},
                         {"pairs", 8},  {"download", 3}, {"exact", 5}};
  frame.result.replays = 1;
  frame.result.step_milliseconds = 10;
  frame.cost.engine_milliseconds = 26;
  return frame;
}

TEST(Observer, StagesOfAllRunsAreWithinThePhaseCompute) {
  Metrics metrics;
  Lifecycle lifecycle;
  ServiceObserver observer(metrics, lifecycle);
  SceneBench bench;
  observer.answered(*bench.add(), frame_with_a_replay());
  const std::string text = metrics.text();
  EXPECT_NEAR(value_of(text, "collided_phase_seconds_sum{phase=\"upload\"}"), 0.001, 1e-9);
  EXPECT_NEAR(value_of(text, "collided_phase_seconds_sum{phase=\"download\"}"), 0.003, 1e-9);
  const double compute = value_of(text, "collided_phase_seconds_sum{phase=\"compute\"}");
  EXPECT_NEAR(compute, 0.022, 1e-9);
  double stages = 0;
  for (const char* stage : {"boxes", "pairs", "exact"})
    stages += value_of(text, "collided_stage_seconds_sum{stage=\"" + std::string(stage) + "\"}");
  EXPECT_NEAR(stages, 0.021, 1e-9);
  EXPECT_LE(stages, compute);
  EXPECT_EQ(value_of(text, "collided_stage_seconds_count{stage=\"pairs\"}"), 2);
  EXPECT_EQ(value_of(text, "collided_stage_seconds_count{stage=\"upload\"}"), -1);
}

}  // namespace
}  // namespace collided::server
