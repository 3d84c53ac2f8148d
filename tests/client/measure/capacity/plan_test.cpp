// How many devices a workload needs: by memory, time and network.

#include "client/measure/capacity/plan.hpp"

#include <gtest/gtest.h>

namespace collided::cli {
namespace {

Workload streams(uint32_t scenes, double rate) {
  Workload workload;
  workload.scenes = scenes;
  workload.rate = rate;
  return workload;
}

SceneCost cost(uint64_t memory_bytes, double step_ms) {
  SceneCost scene;
  scene.memory_bytes = memory_bytes;
  scene.frame_bytes = 1'000'000;
  scene.step_ms = step_ms;
  return scene;
}

const Resource& resource(const Plan& plan, const std::string& name) {
  for (const Resource& each : plan.resources)
    if (each.name == name) return each;
  throw std::out_of_range(name);
}

TEST(Plan, IsBoundByMemory) {
  const Plan plan = plan_of(streams(100, 10), cost(1 << 20, 1), 10 << 20);
  EXPECT_EQ(resource(plan, "memory").scenes_per_device, 10u);
  EXPECT_EQ(resource(plan, "memory").devices, 10u);
  EXPECT_EQ(resource(plan, "time").scenes_per_device, 70u);  // 700 ms of a second, 10 ms each
  EXPECT_EQ(resource(plan, "time").devices, 2u);
  EXPECT_EQ(plan.binding().name, "memory");
}

TEST(Plan, IsBoundByTime) {
  Workload workload = streams(8, 60);
  workload.utilisation = 1;
  const Plan plan = plan_of(workload, cost(1, 10), 1 << 20);
  EXPECT_EQ(plan.binding().name, "time");
  EXPECT_EQ(plan.binding().scenes_per_device, 1u);
  EXPECT_EQ(plan.binding().devices, 8u);
}

TEST(Plan, CountsAWholeSceneWhereOnlyRoundingWouldNot) {
  const Plan plan = plan_of(streams(10, 10), cost(1, 7), 1 << 20);  // 0.7 s of 0.07 s each
  EXPECT_EQ(resource(plan, "time").scenes_per_device, 10u);
}

TEST(Plan, IsBoundByTheBusierWayOfTheNetwork) {
  Workload workload = streams(100, 100);  // 1 MB a frame: 0.8 Gbit/s a scene
  workload.network_gigabits = 10;
  SceneCost scene = cost(1, 0.01);
  EXPECT_EQ(resource(plan_of(workload, scene, 1 << 20), "network").scenes_per_device, 8u);
  scene.bytes_out = 5e6;
  const Plan plan = plan_of(workload, scene, 1 << 20);
  EXPECT_EQ(resource(plan, "network").scenes_per_device, 1u);
  EXPECT_EQ(plan.binding().name, "network");
  EXPECT_EQ(plan.binding().devices, 100u);
}

TEST(Plan, HasNoNetworkInSharedMemory) {
  Workload workload = streams(100, 100);
  workload.network_gigabits = 10;
  workload.transport = "shared-memory";
  EXPECT_EQ(plan_of(workload, cost(1, 0.01), 1 << 20).resources.size(), 2u);
  EXPECT_FALSE(traffic_of(workload, cost(1, 0.01)).in.has_value());
}

TEST(Plan, KnowsMemoryAloneWithoutARate) {
  const Plan plan = plan_of({}, cost(1 << 10, 1), 1 << 20);
  ASSERT_EQ(plan.resources.size(), 1u);
  EXPECT_EQ(plan.binding().scenes_per_device, 1024u);
}

TEST(Plan, NeedsNoNumberOfDevicesForASceneThatIsTooMuchForOne) {
  const Plan plan = plan_of(streams(3, 60), cost(1, 20), 1 << 20);
  EXPECT_EQ(plan.binding().name, "time");
  EXPECT_EQ(plan.binding().scenes_per_device, 0u);
  EXPECT_FALSE(plan.binding().devices.has_value());
}

TEST(Plan, CountsNoMoreScenesThanThereCanBe) {
  const Plan plan = plan_of(streams(UINT32_MAX, 1e-3), cost(0, 1e-6), UINT64_MAX);
  EXPECT_EQ(plan.binding().scenes_per_device, UINT32_MAX);
  EXPECT_EQ(plan.binding().devices, 1u);
}

}  // namespace
}  // namespace collided::cli
