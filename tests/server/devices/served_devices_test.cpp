// Where scenes go: by free memory and load, and never where they do not fit.
#include "server/devices/served_devices.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "server/devices/sharded_bytes.hpp"
#include "server/errors.hpp"
#include "tests/server/hand_clock.hpp"

namespace collided::server {
namespace {

using std::chrono::seconds;

constexpr uint64_t kMegabyte = uint64_t{1} << 20;

class Placing : public testing::Test {
 protected:
  DeviceTerms cpu(int ordinal, uint64_t megabytes) {
    DeviceTerms terms{.info = {.device = {Backend::kCpu, ordinal}}, .max_bytes = megabytes * kMegabyte};
    terms.turns.now = clock_.now();
    return terms;
  }
  static DeviceWish wish(uint64_t megabytes) { return {.min_bytes = megabytes * kMegabyte}; }
  static std::string place(ServedDevices& devices, uint64_t megabytes, std::vector<Placement>& kept) {
    kept.push_back(devices.place(wish(megabytes)));
    return to_string(kept.back().device);
  }
  /// So many seconds of work on a device.
  void work(ServedDevices& devices, int ordinal, int time) {
    TurnAccount account;
    const auto turn = devices.turns({Backend::kCpu, ordinal}).take(account);
    clock_.move(seconds(time));
  }

  HandClock clock_;
  std::vector<Placement> kept_;
};

TEST_F(Placing, GoesToTheMostFreeMemoryAndOfEqualsToTheFirst) {
  ServedDevices devices({cpu(0, 100), cpu(1, 100), cpu(2, 100)});
  for (const char* id : {"cpu:0", "cpu:1", "cpu:2", "cpu:0", "cpu:1", "cpu:2"})
    EXPECT_EQ(place(devices, 10, kept_), id);
  EXPECT_EQ(place(devices, 30, kept_), "cpu:0");
  for (const char* id : {"cpu:1", "cpu:2", "cpu:1"}) EXPECT_EQ(place(devices, 10, kept_), id);
}

TEST_F(Placing, CountsWhatScenesHoldOrWillHoldOnce) {
  ServedDevices devices({cpu(0, 100), cpu(1, 100)});
  EXPECT_EQ(place(devices, 10, kept_), "cpu:0");
  kept_[0].quota->take(4 * kMegabyte);
  EXPECT_EQ(devices.state()[0].free_bytes, 90 * kMegabyte) << "four of its ten are there";
  EXPECT_EQ(devices.state()[0].held_bytes, 4 * kMegabyte);
  kept_[0].quota->take(26 * kMegabyte);
  EXPECT_EQ(devices.state()[0].free_bytes, 70 * kMegabyte);
  EXPECT_EQ(place(devices, 10, kept_), "cpu:1");
  EXPECT_EQ(place(devices, 10, kept_), "cpu:1");
  kept_[0].quota->give_back(30 * kMegabyte);
  kept_.erase(kept_.begin());
  EXPECT_EQ(devices.state()[0].scenes, 0u);
  EXPECT_EQ(devices.state()[0].free_bytes, 100 * kMegabyte);
  EXPECT_EQ(devices.state()[1].scenes, 2u);
  EXPECT_EQ(place(devices, 10, kept_), "cpu:0");
}

TEST_F(Placing, AvoidsABusyDeviceUntilItHasRested) {
  ServedDevices devices({cpu(0, 100), cpu(1, 60)});
  work(devices, 0, 30);
  EXPECT_DOUBLE_EQ(devices.state()[0].load, 1);
  EXPECT_DOUBLE_EQ(devices.state()[0].busy_seconds, 30);
  EXPECT_EQ(devices.preferred(wish(1)).device, (Device{Backend::kCpu, 1})) << "60 / 1, not 100 / 2";
  clock_.move(seconds(3));
  EXPECT_DOUBLE_EQ(devices.state()[0].load, 0.5);
  EXPECT_EQ(place(devices, 1, kept_), "cpu:0") << "100 / 1.5, not 60 / 1";
  clock_.move(seconds(60));
  EXPECT_EQ(devices.state()[0].load, 0);
}

TEST_F(Placing, ABusyDeviceTakesWhatFitsNowhereElse) {
  ServedDevices devices({cpu(0, 100), cpu(1, 60)});
  work(devices, 0, 30);
  EXPECT_EQ(place(devices, 61, kept_), "cpu:0");
}

TEST_F(Placing, IsRefusedWhereNoneHasRoomNamingTheOneWithMost) {
  ServedDevices devices({cpu(0, 50), cpu(1, 60)});
  try {
    place(devices, 61, kept_);
    FAIL() << "placed";
  } catch (const LimitExceeded& error) {
    EXPECT_STREQ(error.what(), ("no device has room: the vertices and triangles of spec.meshes need at least " +
                                std::to_string(61 * kMegabyte) + " bytes, and cpu:1 has most, " +
                                std::to_string(60 * kMegabyte) + " of " + std::to_string(60 * kMegabyte) + " bytes")
                                   .c_str());
  }
  EXPECT_THROW(devices.check_could_hold(wish(61)), LimitExceeded);
  EXPECT_NO_THROW(devices.check_could_hold(wish(60)));
}

TEST_F(Placing, HoldsEachDevicesOwnLimit) {
  ServedDevices devices({cpu(0, 50), cpu(1, 60)});
  DeviceWish first = wish(1);
  first.device = Device{Backend::kCpu, 0};
  const auto client = std::make_shared<DeviceBytes>("client:a", "max", 80 * kMegabyte);
  first.client = client;
  const Placement here = devices.place(first);
  EXPECT_EQ(here.device, *first.device);
  EXPECT_THROW(here.quota->take(51 * kMegabyte), LimitExceeded);
  EXPECT_EQ(client->held(), 0u) << "a refused request is counted nowhere";
  first.device = Device{Backend::kCpu, 1};
  const Placement there = devices.place(first);
  here.quota->take(50 * kMegabyte);
  EXPECT_THROW(there.quota->take(31 * kMegabyte), LimitExceeded) << "the client's";
  EXPECT_EQ(devices.state()[1].held_bytes, 0u);
  there.quota->take(30 * kMegabyte);
  here.quota->give_back(50 * kMegabyte);
  EXPECT_EQ(client->held(), 30 * kMegabyte);
}

TEST_F(Placing, ShardsCountOnTheirDevices) {
  ServedDevices devices({cpu(0, 50), cpu(1, 50), cpu(2, 50)});
  DeviceWish on_three = wish(30);  // ten of each shard
  on_three.shards = {{Backend::kCpu, 2}, {Backend::kCpu, 0}, {Backend::kCpu, 2}};
  std::optional<Placement> placed = devices.place(on_three);
  EXPECT_EQ(placed->device, (Device{Backend::kCpu, 2}));
  ASSERT_EQ(placed->shards.size(), 3u);
  EXPECT_EQ(placed->shards[0], placed->shards[2]) << "on one device";
  placed->shards[0]->take(25 * kMegabyte);
  const auto free_of = [&](size_t device) { return devices.state()[device].free_bytes / kMegabyte; };
  EXPECT_EQ((std::vector{free_of(0), free_of(1), free_of(2)}), (std::vector<uint64_t>{40, 50, 25}));
  EXPECT_EQ(devices.state()[2].scenes, 1u);
  EXPECT_THROW(placed->shards[0]->take(26 * kMegabyte), LimitExceeded);
  placed->shards[0]->give_back(25 * kMegabyte);
  placed.reset();
  EXPECT_EQ((std::vector{free_of(0), free_of(1), free_of(2)}), (std::vector<uint64_t>{50, 50, 50}));
  on_three.min_bytes = 90 * kMegabyte;
  EXPECT_THROW(devices.check_could_hold(on_three), LimitExceeded) << "60 of them on one device";
  on_three.min_bytes = 75 * kMegabyte;
  EXPECT_NO_THROW(devices.check_could_hold(on_three));
}

// The scene's budget and its client's quota are for all shards together.
TEST_F(Placing, ShardsShareTheBudgetOfTheirScene) {
  ServedDevices devices({cpu(0, 50), cpu(1, 50)});
  DeviceWish on_two = wish(2);
  on_two.shards = {{Backend::kCpu, 0}, {Backend::kCpu, 1}};
  on_two.client = std::make_shared<DeviceBytes>("client:a", "max", 80 * kMegabyte);
  const Placement placed = devices.place(on_two);
  EXPECT_EQ(placed.quota, on_two.client);
  ShardedBytes bytes(DeviceBytes::of_scene(60 * kMegabyte, placed.quota), placed.shards);
  bytes.of_shard(0)->take(20 * kMegabyte);
  bytes.of_shard(1)->take(30 * kMegabyte);
  bytes.take(5 * kMegabyte);
  EXPECT_EQ(devices.state()[0].held_bytes, 25 * kMegabyte) << "and what is the scene's as a whole";
  EXPECT_EQ(devices.state()[1].held_bytes, 30 * kMegabyte);
  EXPECT_EQ(on_two.client->held(), 55 * kMegabyte);
  EXPECT_THROW(bytes.of_shard(1)->take(6 * kMegabyte), LimitExceeded) << "the scene's";
  EXPECT_EQ(devices.state()[1].held_bytes, 30 * kMegabyte) << "a refused request is counted nowhere";
  bytes.of_shard(0)->give_back(20 * kMegabyte);
  EXPECT_THROW(bytes.of_shard(1)->take(21 * kMegabyte), LimitExceeded) << "the device's";
  EXPECT_EQ(on_two.client->held(), 35 * kMegabyte);
}

TEST_F(Placing, LimitsFollowTheDaemons) {
  ServedDevices devices({cpu(0, 50), cpu(1, 50)});
  Limits limits;
  limits.max_device_bytes = 20 * kMegabyte;
  devices.set_limits(limits);
  EXPECT_EQ(devices.state()[1].max_bytes, 10 * kMegabyte) << "each has its share";
  EXPECT_THROW(devices.place(wish(11)), LimitExceeded);
}

TEST(DeviceTermsOf, AConfigurationGiveEachItsShare) {
  Config config;
  config.devices = {"cpu:0", "cpu:1"};
  config.limits.max_device_bytes = 64 * kMegabyte;
  const auto terms = devices_at_start(config, Clock::now).terms;
  ASSERT_EQ(terms.size(), 2u);
  for (const DeviceTerms& each : terms) {
    EXPECT_EQ(each.max_bytes, 32 * kMegabyte);
    EXPECT_GT(each.threads, 0);
    EXPECT_EQ(each.turns.concurrent, 2u);
  }
}

}  // namespace
}  // namespace collided::server
