// Each client's usage: streams, frames per second, bytes on devices.
#include "server/limits/client_usage.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <thread>
#include <vector>

#include "server/errors.hpp"
#include "tests/server/hand_clock.hpp"

namespace collided::server {
namespace {

Client client_with(const std::string& name, const ClientLimits& limits) {
  return std::make_shared<ClientIdentity>(ClientIdentity{name, limits});
}

// What refuses it; empty if nothing does.
template <class Body>
std::optional<LimitExceeded> refusal(const Body& body) {
  try {
    body();
  } catch (const LimitExceeded& e) {
    return e;
  }
  return {};
}

TEST(ClientUsage, StreamsCountUntilTheyEnd) {
  Limits limits;
  limits.max_streams = 3;
  ClientUsage usage(limits);
  const auto ann = client_with("ann", {.max_streams = 2}), ben = client_with("ben", {.max_streams = 2});
  auto first = usage.begin_stream(ann);
  const auto second = usage.begin_stream(ann);
  const auto past_own = refusal([&] { usage.begin_stream(ann); });
  ASSERT_TRUE(past_own);
  EXPECT_EQ(past_own->subject(), "client:ann");
  EXPECT_STREQ(past_own->what(), "max_streams_per_client is 2, and client \"ann\" has 2 open streams");
  const auto of_ben = usage.begin_stream(ben);
  const auto past_all = refusal([&] { usage.begin_stream(ben); });
  ASSERT_TRUE(past_all);
  EXPECT_EQ(past_all->subject(), "daemon");
  EXPECT_STREQ(past_all->what(), "max_streams is 3, and 3 streams are open on this daemon");
  EXPECT_EQ(usage.streams(), 3u);
  first.reset();
  EXPECT_EQ(usage.streams(), 2u);
  EXPECT_NO_THROW(usage.begin_stream(ann));
  EXPECT_EQ(usage.streams(), 2u);
}

TEST(ClientUsage, NewLimitsHoldForNewStreams) {
  ClientUsage usage(Limits{});
  const auto ann = client_with("ann", {});
  const auto one = usage.begin_stream(ann), two = usage.begin_stream(ann);
  Limits limits;
  limits.max_streams = 1;
  usage.set_limits(limits);
  EXPECT_EQ(usage.streams(), 2u);
  EXPECT_TRUE(refusal([&] { usage.begin_stream(ann); }));
  limits.max_streams = 3;
  usage.set_limits(limits);
  EXPECT_FALSE(refusal([&] { usage.begin_stream(ann); }));
}

TEST(ClientUsage, AFramePastTheRateTellsWhenItWouldPass) {
  const HandClock clock;  // 5 s after its epoch, which must not refill the bucket
  ClientUsage usage(Limits{}, clock.now());
  const auto slow = client_with("slow", {.max_frames_per_second = 1e-4});
  EXPECT_FALSE(refusal([&] { usage.count_frame(slow); }));
  const auto past = refusal([&] { usage.count_frame(slow); });
  ASSERT_TRUE(past);
  EXPECT_EQ(past->subject(), "client:slow");
  EXPECT_DOUBLE_EQ(past->retry_after_seconds(), 1e4);
  EXPECT_FALSE(refusal([&] { usage.count_frame(client_with("another", {.max_frames_per_second = 1e-4})); }));
  clock.move(std::chrono::seconds(9'999));
  EXPECT_NEAR(refusal([&] { usage.count_frame(slow); })->retry_after_seconds(), 1, 1e-6);
  clock.move(std::chrono::seconds(2));
  EXPECT_FALSE(refusal([&] { usage.count_frame(slow); }));
}

TEST(ClientUsage, ASecondsFramesMayComeAtOnceAndNoMoreThanTheRateAfterThem) {
  constexpr int kRate = 50;
  const HandClock clock;
  ClientUsage usage(Limits{}, clock.now());
  const auto ann = client_with("ann", {.max_frames_per_second = kRate});
  const auto passed = [&] {
    for (int count = 0;; ++count)
      if (refusal([&] { usage.count_frame(ann); })) return count;
  };
  EXPECT_EQ(passed(), kRate);
  clock.move(std::chrono::milliseconds(105));
  EXPECT_EQ(passed(), 5);
  EXPECT_NEAR(refusal([&] { usage.count_frame(ann); })->retry_after_seconds(), 0.015, 1e-6);
  clock.move(std::chrono::hours(1));
  EXPECT_EQ(passed(), kRate);
}

TEST(ClientUsage, DeviceBytesAreTheClientsAndTheDaemons) {
  Limits limits;
  limits.max_device_bytes = 150;
  ClientUsage usage(limits);
  const auto ann = usage.device_bytes(client_with("ann", {.max_device_bytes = 100}));
  const auto ben = usage.device_bytes(client_with("ben", {.max_device_bytes = 100}));
  ann->take(100);
  const auto past_own = refusal([&] { ann->take(1); });
  ASSERT_TRUE(past_own);
  EXPECT_EQ(past_own->subject(), "client:ann");
  EXPECT_STREQ(
      past_own->what(),
      "max_device_bytes_per_client is 100 bytes; the scenes of client:ann hold 100 of them, and 1 more are needed");
  const auto past_all = refusal([&] { ben->take(51); });
  ASSERT_TRUE(past_all);
  EXPECT_EQ(past_all->subject(), "daemon");
  EXPECT_STREQ(past_all->what(),
               "max_device_bytes is 150 bytes; all scenes of this daemon hold 100 of them, and 51 more are needed");
  EXPECT_EQ(ben->held(), 0u);  // what was refused is not held
  ben->take(50);
  ann->give_back(100);
  ben->take(50);
  EXPECT_EQ(ann->held(), 0u);
  EXPECT_EQ(ben->held(), 100u);
}

TEST(ClientUsage, WhatCouldNeverBeHeldIsRefusedWithNeedAndLimit) {
  Limits limits;
  limits.max_device_bytes = 150;
  ClientUsage usage(limits);
  const auto ann = usage.device_bytes(client_with("ann", {.max_device_bytes = 100})),
             ben = usage.device_bytes(client_with("ben", {.max_device_bytes = 200}));
  ann->take(100);  // what is held now does not count
  EXPECT_FALSE(refusal([&] { ann->check_could_hold(100, "meshes"); }));
  const auto own = refusal([&] { ann->check_could_hold(101, "meshes"); });
  ASSERT_TRUE(own);
  EXPECT_EQ(own->subject(), "client:ann");
  EXPECT_STREQ(own->what(), "max_device_bytes_per_client is 100 bytes, but meshes need at least 101");
  const auto all = refusal([&] { ben->check_could_hold(151, "meshes"); });
  ASSERT_TRUE(all);
  EXPECT_EQ(all->subject(), "daemon");
  const auto scene = refusal([&] { DeviceBytes::of_scene(99, ann)->take(100); });
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->field(), "spec.memory_budget_bytes");
  EXPECT_STREQ(scene->what(),
               "spec.memory_budget_bytes is 99 bytes; the scene holds 0 of them, and 100 more are needed");
  EXPECT_EQ(ann->held(), 100u);
}

TEST(ClientUsage, BytesThatOverflowAreRefused) {
  ClientUsage usage(Limits{});
  const auto ann = usage.device_bytes(client_with("ann", {.max_device_bytes = 100}));
  ann->take(60);
  for (const uint64_t bytes : {~uint64_t{0}, ~uint64_t{0} - 59, uint64_t{41}})
    EXPECT_TRUE(refusal([&] { ann->take(bytes); })) << bytes;
  EXPECT_EQ(ann->held(), 60u);
  ann->take(40);
  ann->take(0);
}

TEST(ClientUsage, AClientHasOneCountOfBytesWithItsPresentLimit) {
  ClientUsage usage(Limits{});
  const auto before = usage.device_bytes(client_with("ann", {.max_device_bytes = 100}));
  before->take(80);
  const auto now = usage.device_bytes(client_with("ann", {.max_device_bytes = 50}));
  EXPECT_EQ(before, now);
  EXPECT_EQ(now->held(), 80u);
  EXPECT_TRUE(refusal([&] { before->take(1); }));
  now->give_back(40);
  EXPECT_FALSE(refusal([&] { now->take(10); }));
  Limits limits;
  limits.max_device_bytes = 55;
  usage.set_limits(limits);
  EXPECT_EQ(refusal([&] { usage.device_bytes(client_with("ann", {}))->take(6); })->subject(), "daemon");
}

TEST(ClientUsage, ARefusalDoesNotStandInTheWayOfOthers) {
  Limits limits;
  limits.max_device_bytes = 1000;
  ClientUsage usage(limits);
  const auto greedy = usage.device_bytes(client_with("greedy", {})),
             modest = usage.device_bytes(client_with("modest", {}));
  std::atomic<bool> is_over = false;
  std::thread asks_too_much([&] {
    for (int i = 0; i < 2000; ++i) EXPECT_TRUE(refusal([&] { greedy->take(1001); }));
    is_over = true;
  });
  int refused = 0;
  while (!is_over) {
    if (refusal([&] { modest->take(1); }))
      ++refused;
    else
      modest->give_back(1);
  }
  asks_too_much.join();
  EXPECT_EQ(refused, 0);
}

TEST(ClientUsage, ManyThreadsStayWithinTheLimits) {
  Limits limits;
  limits.max_streams = 5;
  limits.max_device_bytes = 50;
  ClientUsage usage(limits);
  const auto whole = usage.device_bytes(client_with("all", {}));
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, owner = client_with(t % 2 == 0 ? "ann" : "ben", {.max_streams = 2})] {
      for (int i = 0; i < 500; ++i) try {
          const auto stream = usage.begin_stream(owner);
          EXPECT_LE(usage.streams(), 5u);
          usage.count_frame(owner);
          const auto bytes = usage.device_bytes(owner);
          bytes->take(20);
          EXPECT_LE(bytes->held(), 50u);
          bytes->give_back(20);
          usage.set_limits(limits);
        } catch (const LimitExceeded&) {
        }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(usage.streams(), 0u);
  EXPECT_FALSE(refusal([&] { whole->take(50); }));  // all came back
}

}  // namespace
}  // namespace collided::server
