// Every limit of the daemon is exceeded once, and the refusal names it.
#include <gtest/gtest.h>

#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

// Opens a stream that must be refused.
grpc::Status refused_stream(Stub& stub, const std::string& id, uint32_t window = 0) {
  Stream stream(stub, id, window);
  EXPECT_FALSE(stream.opened());
  return stream.finish();
}

TEST(Limits, ScenesOfTheDaemon) {
  DaemonProcess daemon({"--max-scenes", "2", "--max-scenes-per-client", "2"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto id = make_scene(*stub, tip_request());
  make_scene(*stub, tip_request());
  expect_quota(create_scene(*stub, tip_request()), "max_scenes", "daemon");
  EXPECT_TRUE(delete_scene(*stub, id).ok());
  EXPECT_TRUE(create_scene(*stub, tip_request()).ok());
}

TEST(Limits, ScenesOfAClient) {
  DaemonProcess daemon({"--max-scenes-per-client", "1"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  make_scene(*stub, tip_request());
  expect_quota(create_scene(*stub, tip_request()), "max_scenes_per_client", "client:");
}

// So that none of them shuts out the others.
TEST(Limits, AClientHasAQuarterOfWhatAllHave) {
  DaemonProcess daemon({"--max-scenes", "8", "--max-streams", "3", "--max-device-mb", "100"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  make_scene(*stub, tip_request());
  make_scene(*stub, tip_request());
  expect_quota(create_scene(*stub, tip_request()), "max_scenes_per_client is 2", "client:");
  grpc::ClientContext context;
  set_deadline(context);
  pb::GetServerInfoResponse info;
  ASSERT_TRUE(stub->GetServerInfo(&context, {}, &info).ok());
  EXPECT_EQ(info.limits().max_streams_per_client(), 1u);
  EXPECT_EQ(info.limits().max_device_bytes_per_client(), 25u << 20);
  EXPECT_EQ(info.limits().max_scene_bytes(), 25u << 20);
}

TEST(Limits, StreamsOfTheDaemon) {
  DaemonProcess daemon({"--max-streams", "1"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto one = make_scene(*stub, tip_request()), other = make_scene(*stub, tip_request());
  {
    Stream stream(*stub, one);
    ASSERT_TRUE(stream.opened());
    expect_quota(refused_stream(*stub, other), "max_streams", "daemon");
    expect_tip_contact(stream.ask(first_frame(2)), 2);
    EXPECT_TRUE(stream.finish().ok());
  }
  EXPECT_TRUE(Stream(*stub, other).opened());
}

TEST(Limits, StreamsOfAClient) {
  DaemonProcess daemon({"--max-streams-per-client", "1"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  Stream stream(*stub, make_scene(*stub, tip_request()));
  ASSERT_TRUE(stream.opened());
  expect_quota(refused_stream(*stub, make_scene(*stub, tip_request())), "max_streams_per_client", "client:");
}

TEST(Limits, Windows) {
  DaemonProcess daemon({"--max-window", "4"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto id = make_scene(*stub, tip_request());
  for (const uint32_t window : {5u, 0xffffffffu})
    expect_field(refused_stream(*stub, id, window), grpc::RESOURCE_EXHAUSTED, "open.window");
  Stream stream(*stub, id, 4);
  ASSERT_TRUE(stream.opened());
  EXPECT_EQ(stream.opened()->window(), 4u);
}

// The stream continues, and the same frame is accepted after the time that the refusal gives.
TEST(Limits, FramesInASecond) {
  DaemonProcess daemon({"--max-frames-per-second", "2"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto id = make_scene(*stub, tip_request());
  Stream stream(*stub, id);
  uint64_t next = 1;
  Answer answer = stream.ask(first_frame(2));
  for (; answer.done && next < 1000; answer = stream.ask(tip_frame(next, 2))) ++next;
  ASSERT_TRUE(answer.error);
  EXPECT_EQ(answer.error->code(), grpc::RESOURCE_EXHAUSTED);
  EXPECT_NE(answer.error->message().find("max_frames_per_second is 2"), std::string::npos) << answer.error->message();
  EXPECT_GT(answer.error->retry_after_seconds(), 0);
  EXPECT_LE(answer.error->retry_after_seconds(), 0.5);
  const std::chrono::duration<double> pause(answer.error->retry_after_seconds());
  std::this_thread::sleep_for(pause);
  expect_tip_contact(stream.ask(tip_frame(next, 3)), 3);
}

TEST(Limits, FramesInASecondOfUnaryCalls) {
  DaemonProcess daemon({"--max-frames-per-second", "0.01"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto id = make_scene(*stub, tip_request());
  EXPECT_TRUE(detect(*stub, id, first_frame(2)).ok());
  const auto status = detect(*stub, id, tip_frame(2, 2));
  expect_quota(status, "max_frames_per_second", "client:");
  EXPECT_NE(status.error_details().find("google.rpc.RetryInfo"), std::string::npos);
}

TEST(Limits, AreTold) {
  DaemonProcess daemon({"--max-scenes",
                        "7",
                        "--max-streams",
                        "8",
                        "--max-window",
                        "9",
                        "--max-frames-per-second",
                        "10",
                        "--max-idle-seconds",
                        "11",
                        "--max-lease-seconds",
                        "40",
                        "--max-scenes-per-client",
                        "6",
                        "--max-streams-per-client",
                        "5",
                        "--max-frame-seconds",
                        "12.5",
                        "--max-accuracy",
                        "fast",
                        "--max-device-mb",
                        "4",
                        "--max-device-mb-per-client",
                        "3"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  grpc::ClientContext context;
  set_deadline(context);
  pb::GetServerInfoResponse info;
  ASSERT_TRUE(stub->GetServerInfo(&context, {}, &info).ok());
  const auto& limits = info.limits();
  EXPECT_EQ(limits.max_scenes(), 7u);
  EXPECT_EQ(limits.max_streams(), 8u);
  EXPECT_EQ(limits.max_window(), 9u);
  EXPECT_EQ(limits.max_frames_per_second(), 10);
  EXPECT_EQ(limits.max_idle_seconds(), 11);
  EXPECT_EQ(limits.max_lease_seconds(), 40);
  EXPECT_EQ(limits.max_scenes_per_client(), 6u);
  EXPECT_EQ(limits.max_streams_per_client(), 5u);
  EXPECT_EQ(limits.max_frame_seconds(), 12.5);
  EXPECT_EQ(limits.min_ping_seconds(), 0.1);
  EXPECT_EQ(limits.max_accuracy(), pb::ACCURACY_FAST);
  EXPECT_EQ(limits.max_device_bytes(), 4u << 20);
  EXPECT_EQ(limits.max_device_bytes_per_client(), 3u << 20);
}

}  // namespace
}  // namespace collided::test
