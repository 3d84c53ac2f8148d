// Unset limits, derived from the memory of the host and the device.
#include "server/config/memory_limits.hpp"

#include <gtest/gtest.h>

#include "server/config/accuracy_names.hpp"
#include "tests/server/config/parse.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMegabyte = uint64_t{1} << 20, kGigabyte = uint64_t{1} << 30;

Limits derived(const Memory& memory, Limits limits = underived_limits()) {
  derive_limits(limits, memory);
  return limits;
}

TEST(MemoryLimits, HalfOfTheHostIsForScenes) {
  for (const auto& [host, all] : {std::pair<uint64_t, uint64_t>{2, 1024}, {8, 4096}, {23, 11'776}, {256, 131'072}}) {
    const Limits limits = derived({host * kGigabyte, 0});
    EXPECT_EQ(limits.max_device_bytes, all * kMegabyte) << host;
    EXPECT_EQ(limits.client.max_device_bytes, all / 4 * kMegabyte) << host;
    EXPECT_EQ(limits.max_scene_bytes, all / 4 * kMegabyte) << host;
    EXPECT_EQ(limits.client.max_scenes, 16u);
    EXPECT_EQ(limits.client.max_streams, 64u);
  }
}

TEST(MemoryLimits, ADeviceWithLessThanThatSetsThem) {
  EXPECT_EQ(derived({256 * kGigabyte, 80 * kGigabyte}).max_device_bytes, 72 * kGigabyte);
  EXPECT_EQ(derived({8 * kGigabyte, 80 * kGigabyte}).max_device_bytes, 4 * kGigabyte);
}

TEST(MemoryLimits, WithoutAWordOnTheHostItHas8Gigabytes) {
  EXPECT_EQ(derived({}), derived({8 * kGigabyte, 0}));
  EXPECT_EQ(derived({}), Limits());
}

TEST(MemoryLimits, WhatIsSetStays) {
  Limits set = underived_limits();
  set.max_device_bytes = 100 * kGigabyte;
  set.max_scenes = 10;
  set.max_streams = 1;
  Limits limits = derived({8 * kGigabyte, 0}, set);
  EXPECT_EQ(limits.max_device_bytes, 100 * kGigabyte);
  EXPECT_EQ(limits.client.max_device_bytes, 25 * kGigabyte);
  EXPECT_EQ(limits.max_scene_bytes, 25 * kGigabyte);
  EXPECT_EQ(limits.client.max_scenes, 3u);
  EXPECT_EQ(limits.client.max_streams, 1u);
  set.client.max_device_bytes = 7 * kMegabyte;
  set.client.max_scenes = 9;
  limits = derived({8 * kGigabyte, 0}, set);
  EXPECT_EQ(limits.max_scene_bytes, 7 * kMegabyte);
  EXPECT_EQ(limits.client.max_scenes, 9u);
}

TEST(MemoryLimits, AreNeverNothing) {
  const Limits limits = derived({1, 0});
  EXPECT_EQ(limits.max_device_bytes, kMegabyte);
  EXPECT_EQ(limits.client.max_device_bytes, kMegabyte);
  EXPECT_EQ(limits.max_scene_bytes, kMegabyte);
}

TEST(MemoryLimits, OptionsAreZeroUntilTheyAreDerived) {
  const auto parsed = parse({"--max-device-mb", "0", "--max-streams-per-client", "0"});
  ASSERT_TRUE(parsed.run) << parsed.text;
  EXPECT_EQ(parsed.config.limits, underived_limits());
  EXPECT_EQ(derived({8 * kGigabyte, 0}, parsed.config.limits), Limits());
  EXPECT_NE(parse({"--help"}).text.find("0: derived from the memory"), std::string::npos);
}

TEST(MemoryLimits, WhatIsOnItsWayHasAnEighthAtMost) {
  EXPECT_EQ(derived({kGigabyte, 0}).max_network_bytes, kGigabyte / 8);
  EXPECT_EQ(derived({kGigabyte, 0}).max_decode_bytes, kGigabyte / 8);
  EXPECT_EQ(derived({256 * kGigabyte, 0}).max_network_bytes, kGigabyte / 2);
  EXPECT_EQ(derived({256 * kGigabyte, 0}).max_decode_bytes, kGigabyte / 4);
}

TEST(MemoryLimits, AreToldInOneLine) {
  EXPECT_EQ(describe_limits(derived({8 * kGigabyte, 0}), {8 * kGigabyte, 0}),
            "memory: host 8192 MiB; limits: all scenes 4096 MiB, those of a client 1024 MiB, one scene 1024 MiB, "
            "network buffers 512 MiB, decoded messages 256 MiB; a client 16 of 64 scenes, 64 of 256 streams");
  EXPECT_NE(describe_limits(derived({0, kGigabyte}), {0, kGigabyte}).find("host unknown, device 1024 MiB;"),
            std::string::npos);
}

TEST(MemoryLimits, FramesAreBoundedInTimeAndAccuracy) {
  const auto parsed = parse({"--max-frame-seconds", "0.5", "--max-accuracy", "guarded"});
  ASSERT_TRUE(parsed.run) << parsed.text;
  EXPECT_EQ(parsed.config.limits.client.max_frame_seconds, 0.5);
  EXPECT_EQ(parsed.config.limits.client.max_accuracy, Accuracy::kGuarded);
  EXPECT_EQ(parse({}).config.limits.client.max_frame_seconds, 10);
  EXPECT_EQ(parse({}).config.limits.client.max_accuracy, Accuracy::kExact);
  for (const auto& [flag, value] :
       {std::pair{"--max-accuracy", "best"}, {"--max-accuracy", ""}, {"--max-frame-seconds", "0"}}) {
    EXPECT_EQ(parse({flag, value}).exit_code, 2) << value;
    EXPECT_NE(parse({flag, value}).text.find(flag), std::string::npos);
  }
  for (const auto& name : accuracy_names()) EXPECT_EQ(name_of(accuracy_named(name).value()), name);
}

}  // namespace
}  // namespace collided::server
