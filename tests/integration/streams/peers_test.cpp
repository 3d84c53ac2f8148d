// Clients that stop, vanish, or read too slowly: the daemon lets go of them, and its memory stays bounded.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/integration/support/layers.hpp"
#include "tests/integration/support/peers/child_client.hpp"
#include "tests/integration/support/peers/tcp_proxy.hpp"
#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

constexpr double kLease = 1;
constexpr uint32_t kSmall = 10;
constexpr uint32_t kLarge = 80;  // some MiB of contacts per frame
constexpr double kOneMessage = 2.1 * (1 << 20);

class Peers : public testing::Test {
 protected:
  static pb::CreateSceneRequest leased_tip() {
    auto request = tip_request();
    request.set_lease_seconds(kLease);
    return request;
  }

  void expect_all_released() {
    EXPECT_TRUE(probe_.streams_become(0));
    EXPECT_TRUE(probe_.scenes_become(0));
    EXPECT_TRUE(probe_.becomes("collided_device_bytes", 0));
    EXPECT_EQ(probe_.metric("collided_outgoing_bytes"), 0);
  }

  DaemonProcess daemon_{{"--address", "127.0.0.1:0", "--keepalive-seconds", "1", "--keepalive-timeout-seconds", "1"}};
  Probe probe_{daemon_};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

TEST_F(Peers, AKilledClientLeavesItsSceneToItsLease) {
  ChildClient client(daemon_.tcp_address(), make_scene(*stub_, layers_request(kSmall, kLease)), kSmall);
  ASSERT_TRUE(client.is_answered());
  EXPECT_EQ(probe_.streams(), 1);
  client.signal(SIGKILL);
  expect_all_released();
  EXPECT_TRUE(probe_.becomes("collided_calls_total{code=\"CANCELLED\",method=\"StreamFrames\"}", 1));
  EXPECT_EQ(probe_.metric("collided_calls_total{code=\"OK\",method=\"StreamFrames\"}"), 0);
}

TEST_F(Peers, AStoppedClientIsLeft) {
  ChildClient client(daemon_.tcp_address(), make_scene(*stub_, layers_request(kSmall, kLease)), kSmall);
  ASSERT_TRUE(client.is_answered());
  client.signal(SIGSTOP);
  expect_all_released();
}

// Its socket is full, so pings do not get out either.
TEST_F(Peers, AClientThatStopsWithinLargeAnswersIsLeft) {
  ChildClient client(daemon_.tcp_address(), make_scene(*stub_, layers_request(kLarge, kLease)), kLarge);
  ASSERT_TRUE(client.is_answered());
  client.signal(SIGSTOP);
  expect_all_released();
}

// A full Unix socket lets no ping through: the idle timeout applies, and one message stays until the client ends.
TEST(UnixPeers, AClientThatStopsIsLeft) {
  DaemonProcess daemon({"--max-idle-seconds", "1"});
  const Probe probe(daemon);
  const auto stub = pb::CollisionService::NewStub(daemon.channel());
  ChildClient client(daemon.address(), make_scene(*stub, layers_request(kLarge, kLease)), kLarge);
  ASSERT_TRUE(client.is_answered());
  client.signal(SIGSTOP);
  EXPECT_TRUE(probe.streams_become(0));
  EXPECT_TRUE(probe.scenes_become(0));
  EXPECT_LE(probe.metric("collided_outgoing_bytes"), kOneMessage);
  EXPECT_GT(probe.device_bytes(), 0) << "the answer that it is of";
  client.signal(SIGKILL);
  EXPECT_TRUE(probe.becomes("collided_outgoing_bytes", 0));
  EXPECT_TRUE(probe.becomes("collided_device_bytes", 0));
}

TEST(UnixPeers, AClientThatStoppedDoesNotKeepTheDaemonFromStopping) {
  for (const bool is_local : {true, false}) {
    DaemonProcess daemon({"--address", "127.0.0.1:0", "--grace-seconds", "1"});
    const auto stub = pb::CollisionService::NewStub(daemon.channel());
    const auto scene = make_scene(*stub, layers_request(kLarge, kLease));
    ChildClient client(is_local ? daemon.address() : daemon.tcp_address(), scene, kLarge);
    ASSERT_TRUE(client.is_answered());
    client.signal(SIGSTOP);
    EXPECT_EQ(daemon.stop(), 0) << (is_local ? "Unix socket" : "TCP");
  }
}

TEST_F(Peers, ABrokenConnectionEndsItsStreamAndIsResumedOnAnother) {
  TcpProxy proxy(daemon_.tcp_address());
  const auto scene = made_scene(*stub_, tip_request());
  auto stub = pb::CollisionService::NewStub(channel_to(proxy.address()));
  Stream stream(*stub, scene.scene_id());
  expect_tip_contact(stream.ask(first_frame(2)), 2);
  proxy.cut();
  EXPECT_TRUE(stream.ask(tip_frame(2, 2)).ended);
  EXPECT_EQ(stream.wait_end().error_code(), grpc::UNAVAILABLE);
  EXPECT_TRUE(probe_.streams_become(0));
  Stream next(*stub_, scene.scene_id(), 0, scene.resume_token());
  ASSERT_TRUE(next.opened());
  EXPECT_EQ(next.opened()->scene().last_frame_id(), 1u);
  expect_tip_contact(next.ask(tip_frame(2, 4)), 4);
}

TEST_F(Peers, AnUnpluggedConnectionIsSeenByKeepalive) {
  TcpProxy proxy(daemon_.tcp_address());
  auto stub = pb::CollisionService::NewStub(channel_to(proxy.address()));
  Stream stream(*stub, make_scene(*stub_, leased_tip()));
  expect_tip_contact(stream.ask(first_frame(2)), 2);
  EXPECT_EQ(probe_.streams(), 1);
  proxy.unplug();
  expect_all_released();
  proxy.cut();
  EXPECT_FALSE(stream.wait_end().ok());
}

// The daemon computes no further than the client takes.
TEST_F(Peers, ASlowReaderDoesNotFillTheDaemon) {
  constexpr uint64_t kFrames = 16;
  Stream stream(*stub_, make_scene(*stub_, layers_request(kLarge)), kFrames);
  const auto positions = pack_points(layer_points(kLarge));
  const double before = probe_.resident_bytes();
  for (uint64_t id = 1; id <= kFrames; ++id) stream.send(layers_frame(id, positions));
  double most_outgoing = 0, bytes = 0, answer_bytes = 0;
  for (uint64_t id = 1; id <= kFrames; ++id) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    most_outgoing = std::max(most_outgoing, probe_.metric("collided_outgoing_bytes"));
    EXPECT_LT(probe_.resident_bytes() - before, memory_limit(160));
    const Answer answer = stream.receive(id);
    ASSERT_TRUE(answer.done);
    answer_bytes = static_cast<double>(answer.done->metrics().bytes_out());
    bytes += answer_bytes;
  }
  EXPECT_GT(bytes, 40e6);  // much more than may wait
  EXPECT_LE(most_outgoing, (16 << 20) + 1.1 * answer_bytes);
  EXPECT_TRUE(stream.finish().ok());
  EXPECT_EQ(probe_.metric("collided_outgoing_bytes"), 0);
}

// Frames sent past the credits stay in the connection until there is room.
TEST_F(Peers, AFloodPastTheCreditsDoesNotFillTheDaemon) {
  constexpr uint64_t kFrames = 100;
  constexpr uint32_t kSide = 60, kWindow = 2;
  Stream stream(*stub_, make_scene(*stub_, layers_request(kSide)), kWindow);
  const auto positions = pack_points(layer_points(kSide, kLayersApart));
  const double before = probe_.resident_bytes();
  std::thread flood([&] {
    for (uint64_t id = 1; id <= kFrames; ++id) stream.send(layers_frame(id, positions));
  });
  for (uint64_t id = 1; id <= kFrames; ++id) {
    const Answer answer = stream.receive(id);
    EXPECT_TRUE(answer.done && answer.chunks.empty()) << id;
    if (id % 10) continue;
    EXPECT_LE(probe_.metric("collided_queued_frames"), kWindow);
    EXPECT_LT(probe_.resident_bytes() - before, memory_limit(64));
  }
  flood.join();
  EXPECT_TRUE(stream.finish().ok());
}

}  // namespace
}  // namespace collided::test
