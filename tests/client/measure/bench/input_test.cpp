// The inputs that 'collidectl bench' plays, and their order.

#include "client/measure/bench/input.hpp"

#include <gtest/gtest.h>

namespace collided::cli {
namespace {

using Steps = std::vector<int>;

TEST(Bench, TheWarmUpIsSpreadOverTheMotionAndEndsWithItsLastStep) {
  EXPECT_EQ(planned_steps(4, 0), (Steps{1, 2, 3, 4}));
  EXPECT_EQ(planned_steps(4, 2), (Steps{2, 4, 1, 2, 3, 4}));
  EXPECT_EQ(planned_steps(2, 3), (Steps{1, 2, 2, 1, 2}));
  EXPECT_EQ(planned_steps(1, 1), (Steps{1, 1}));
  EXPECT_EQ(planned_steps(1000000, 1000000).at(999999), 1000000);
}

/// A moving triangle and a static one; every coordinate encodes the step, before and after.
BenchInput input() {
  const auto positions = [](double x) { return std::vector<scenes::Vec3d>(6, {x, x, x}); };
  return {.name = "made",
          .meshes = {{"moves", 3, {{0, 1, 2}}, false}, {"stands", 3, {{0, 1, 2}}, true}},
          .start = [=](int step, int) { return positions(step - 1); },
          .end = [=](int step, int) { return positions(step); }};
}

v1::SceneSpec spec_of(v1::DetectionMode mode) {
  v1::SceneSpec spec;
  spec.set_mode(mode);
  spec.set_position_format(v1::POSITION_FORMAT_F32);
  return spec;
}

std::string packed(float x) {
  const std::vector<float> floats(9, x);
  return {reinterpret_cast<const char*>(floats.data()), floats.size() * sizeof(float)};
}

TEST(Bench, FramesTellTheirStartWhereTheMotionJumps) {
  const Steps plan = planned_steps(2, 1);  // 2, 1, 2
  std::vector<v1::Frame> frames;
  for (size_t at = 0; at < plan.size(); ++at)
    frames.push_back(planned_frame(input(), plan, at, 2, spec_of(v1::DETECTION_MODE_CCD)));
  ASSERT_EQ(frames[0].updates_size(), 2);  // static meshes come once
  EXPECT_TRUE(frames[0].updates(1).start_positions().empty());
  const std::string starts[] = {packed(1), packed(0), ""};
  for (size_t at = 0; at < plan.size(); ++at) {
    EXPECT_EQ(frames[at].frame_id(), at + 1);
    EXPECT_EQ(frames[at].updates_size(), at == 0 ? 2 : 1);
    EXPECT_EQ(frames[at].updates(0).start_positions(), starts[at]) << at;
    EXPECT_EQ(frames[at].updates(0).positions(), packed(static_cast<float>(plan[at]))) << at;
  }
}

TEST(Bench, AStepThatIsRepeatedAlwaysTellsItsStart) {
  BenchInput same = input();
  same.is_motion = false;
  const Steps plan = planned_steps(2, 0);
  for (size_t at = 0; at < plan.size(); ++at)
    EXPECT_FALSE(
        planned_frame(same, plan, at, 2, spec_of(v1::DETECTION_MODE_CCD)).updates(0).start_positions().empty());
}

TEST(Bench, DiscreteFramesHaveNoStart) {
  const Steps plan = planned_steps(2, 1);
  for (size_t at = 0; at < plan.size(); ++at)
    EXPECT_TRUE(
        planned_frame(input(), plan, at, 2, spec_of(v1::DETECTION_MODE_DCD)).updates(0).start_positions().empty());
}

TEST(Bench, ASceneGoesFromItsStartToItsEnd) {
  const auto scene = scenes::make_scene("funnel", 0.1);
  const BenchInput funnel = scene_input("funnel", 0.1);
  EXPECT_EQ(funnel.start(1, 4), scene->positions(0));
  EXPECT_EQ(funnel.end(1, 4), scene->positions(0.25));
  EXPECT_EQ(funnel.start(4, 4), scene->positions(0.75));
  EXPECT_EQ(funnel.end(4, 4), scene->positions(1));
}

}  // namespace
}  // namespace collided::cli
