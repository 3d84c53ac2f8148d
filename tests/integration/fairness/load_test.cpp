// Many scenes and streams at once: order, fair shares, and a stop under load.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "tests/integration/support/layers.hpp"
#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

using Threads = std::vector<std::jthread>;

/// Streams tip frames with as many in flight as the window allows, and checks every contact.
void stream_tips(const std::string& address, int number, uint64_t frames, uint32_t window) {
  auto stub = pb::CollisionService::NewStub(channel_to(address, number));
  Stream stream(*stub, make_scene(*stub, tip_request()), window);
  ASSERT_TRUE(stream.opened());
  const auto depth = [&](uint64_t id) { return 1.5 + 0.125 * (id % 8) + number; };
  const auto send = [&](uint64_t id) { stream.send(id == 1 ? first_frame(depth(1)) : tip_frame(id, depth(id))); };
  for (uint64_t id = 1; id <= std::min<uint64_t>(window, frames); ++id) send(id);
  for (uint64_t id = 1; id <= frames; ++id) {
    expect_tip_contact(stream.receive(id), depth(id));
    if (id + window <= frames) send(id + window);
  }
  EXPECT_TRUE(stream.finish().ok());
}

TEST(Load, SixteenActiveScenes) {
  DaemonProcess daemon;
  const Probe probe(daemon);
  const double before = probe.metric("process_resident_memory_bytes");
  {
    Threads threads;
    for (int i = 0; i < 16; ++i) threads.emplace_back([&, i] { stream_tips(daemon.address(), i, 50, 16); });
  }
  EXPECT_TRUE(probe.streams_become(0));
  EXPECT_EQ(probe.scenes(), 16);
  EXPECT_LT(probe.metric("process_resident_memory_bytes") - before, memory_limit(256));
  EXPECT_EQ(probe.metric("collided_outgoing_bytes"), 0);
  EXPECT_EQ(probe.metric("collided_frames_total"), 16 * 50);
}

TEST(Load, TwoHundredIdleStreams) {
  constexpr int kStreams = 200;
  DaemonProcess daemon({"--max-scenes", "201", "--max-scenes-per-client", "201", "--max-streams-per-client", "201"});
  const Probe probe(daemon);
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const double before = probe.metric("process_resident_memory_bytes");
  {
    std::vector<std::unique_ptr<Stream>> streams;
    for (int i = 0; i < kStreams; ++i) {
      streams.push_back(std::make_unique<Stream>(*stub, make_scene(*stub, tip_request())));
      ASSERT_TRUE(streams.back()->opened()) << i;
    }
    EXPECT_EQ(probe.streams(), kStreams);
    EXPECT_LT(probe.metric("process_resident_memory_bytes") - before, memory_limit(256));
    stream_tips(daemon.address(), 1, 50, 4);
    expect_tip_contact(streams.front()->ask(first_frame(2)), 2);
    expect_tip_contact(streams.back()->ask(first_frame(3)), 3);
    EXPECT_EQ(probe.metric("collided_queued_frames"), 0);
  }
  EXPECT_TRUE(probe.streams_become(0));
}

// One frame is computed at a time. First come, first served would make a small frame wait for everything that the large
// scene has in flight.
TEST(Load, SmallScenesGetTheirTurnsBesideALargeOne) {
  constexpr uint32_t kWindow = 16, kSide = 60;
  constexpr uint64_t kSmallFrames = 10, kMostLargeFrames = 100;
  constexpr int kSmallScenes = 4;
  DaemonProcess daemon({"--concurrent-frames", "1"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto positions = pack_points(layer_points(kSide, kLayersApart));
  Stream large(*stub, make_scene(*stub, layers_request(kSide)), kWindow);
  for (uint64_t id = 1; id <= kWindow; ++id) large.send(layers_frame(id, positions));
  ASSERT_TRUE(large.receive(1).done);
  std::atomic<int> ready = 0;
  Threads threads;
  for (int i = 0; i < kSmallScenes; ++i)
    threads.emplace_back([&, i] {
      stream_tips(daemon.address(), i + 1, kSmallFrames, kWindow);
      ++ready;
    });
  uint64_t answered = 1;
  for (; ready < kSmallScenes && answered < kMostLargeFrames; ++answered) {
    large.send(layers_frame(answered + kWindow, positions));
    ASSERT_TRUE(large.receive(answered + 1).done);
  }
  EXPECT_EQ(ready, kSmallScenes) << "after " << answered << " frames of the large scene";
}

TEST(Load, RefusalsKeepTheOrderOfTheFrames) {
  constexpr uint64_t kFrames = 16;
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  Stream stream(*stub, make_scene(*stub, layers_request(40)), kFrames);
  const auto good = pack_points(layer_points(40, kLayersApart));
  const auto is_bad = [](uint64_t id) { return id % 3 == 0; };
  for (uint64_t id = 1; id <= kFrames; ++id) stream.send(layers_frame(id, is_bad(id) ? good.substr(1) : good));
  for (uint64_t id = 1; id <= kFrames; ++id) {
    const Answer answer = stream.receive(id);
    EXPECT_EQ(answer.done.has_value(), !is_bad(id)) << id;
    EXPECT_EQ(answer.error.has_value(), is_bad(id)) << id;
  }
}

// Streams until the stop is announced; then receives the outstanding answers, and ends.
void stream_until_told(const std::string& address, int number, std::atomic<int>& running) {
  constexpr uint64_t kWindow = 4;
  auto stub = pb::CollisionService::NewStub(channel_to(address, number));
  Stream stream(*stub, make_scene(*stub, layers_request(30)), kWindow);
  const auto positions = pack_points(layer_points(30));
  uint64_t sent = 0, answered = 0;
  while (stream.drainings() == 0) {
    while (sent < answered + kWindow) stream.send(layers_frame(++sent, positions));
    ASSERT_TRUE(stream.receive(++answered).done);
    if (answered == 1) ++running;
  }
  while (answered < sent) ASSERT_TRUE(stream.receive(++answered).done);
  EXPECT_TRUE(stream.finish().ok());
}

TEST(Load, AStopUnderLoadAnswersAllThatWasSent) {
  constexpr int kScenes = 4;
  DaemonProcess daemon({"--grace-seconds", "30"});
  std::atomic<int> running = 0;
  Threads threads;
  for (int i = 0; i < kScenes; ++i) threads.emplace_back([&, i] { stream_until_told(daemon.address(), i, running); });
  eventually("all run", [&] { return running == kScenes; });
  daemon.signal(SIGTERM);
  threads.clear();
  EXPECT_EQ(daemon.wait(), 0);
}

TEST(Load, AStopEndsThoseWhoDoNotListen) {
  DaemonProcess daemon({"--grace-seconds", "0.5"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  Stream stream(*stub, make_scene(*stub, layers_request(30)), 4);
  const auto positions = pack_points(layer_points(30));
  ASSERT_TRUE(stream.ask(layers_frame(1, positions)).done);
  daemon.signal(SIGTERM);
  uint64_t id = 2;
  while (stream.ask(layers_frame(id, positions)).done) ++id;
  EXPECT_EQ(stream.drainings(), 1);
  const auto code = stream.wait_end().error_code();
  EXPECT_TRUE(code == grpc::UNAVAILABLE || code == grpc::CANCELLED || code == grpc::INTERNAL) << code;
  EXPECT_EQ(daemon.wait(), 0);
}

}  // namespace
}  // namespace collided::test
