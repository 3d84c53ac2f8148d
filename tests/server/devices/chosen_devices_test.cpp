// Which devices of this machine the daemon serves.
#include "server/devices/chosen_devices.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

namespace collided::server {
namespace {

Config config_with(std::vector<std::string> devices, int threads = 0) {
  Config config;
  config.devices = std::move(devices);
  config.threads = threads;
  return config;
}

std::vector<std::string> ids_of(const std::vector<DeviceInfo>& devices) {
  std::vector<std::string> ids;
  for (const DeviceInfo& info : devices) ids.push_back(to_string(info.device));
  return ids;
}

TEST(ChosenDevices, AreAllThatAreThereUnlessSomeAreNamed) {
  const auto all = ids_of(chosen_devices(Config()));
  EXPECT_EQ(all.size(), list_devices().size());
  EXPECT_EQ(all.front(), "cpu:0");
  EXPECT_EQ(ids_of(chosen_devices(config_with({"cpu:1", "cpu"}))), (std::vector<std::string>{"cpu:0", "cpu:1"}));
}

TEST(ChosenDevices, OfTheCpuShareItsCores) {
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  EXPECT_EQ(threads_of_scene(Config(), Backend::kCpu), 0) << "all";
  EXPECT_EQ(threads_of_scene(config_with({"cpu:0"}), Backend::kCpu), 0);
  EXPECT_EQ(threads_of_scene(config_with({"cpu:0", "cpu:1"}), Backend::kCpu), std::max(1, cores / 2));
  EXPECT_EQ(threads_of_scene(config_with({"cpu:0", "cpu:1"}, 3), Backend::kCpu), 3);
  EXPECT_EQ(threads_of_scene(config_with({"cpu:0", "cpu:1"}), Backend::kCuda), 0);
}

TEST(ChosenDevices, OneThatIsNotThereIsNamed) {
  const size_t gpus = list_devices().size() - 1;
  try {
    chosen_devices(config_with({"cuda:" + std::to_string(gpus)}));
    FAIL() << "a device was made up";
  } catch (const ConfigError& error) {
    const std::string what = error.what();
    EXPECT_TRUE(what.starts_with("--device is cuda:" + std::to_string(gpus))) << what;
    EXPECT_NE(what.find(gpus == 0 ? "which cannot be used: " : "this machine has " + std::to_string(gpus)),
              std::string::npos)
        << what;
  }
}

}  // namespace
}  // namespace collided::server
