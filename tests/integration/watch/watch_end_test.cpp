// Who may watch, what is refused, and how watches end.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "tests/integration/support/client_channel.hpp"
#include "tests/integration/support/layers.hpp"
#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"
#include "tests/integration/support/watch.hpp"

namespace collided::test {
namespace {

class WatchEnds : public testing::Test {
 protected:
  void start(std::vector<std::string> options = {}) {
    daemon_.emplace(std::move(options));
    probe_.emplace(*daemon_);
    stub_ = pb::CollisionService::NewStub(daemon_->channel());
  }
  grpc::Status refusal(const std::string& id, const std::function<void(pb::WatchSceneRequest&)>& more = {}) {
    Watch watch(*stub_, watch_request(id, more));
    EXPECT_FALSE(watch.opened());
    return watch.wait_end();
  }

  std::optional<DaemonProcess> daemon_;
  std::optional<Probe> probe_;
  std::unique_ptr<Stub> stub_;
};

TEST_F(WatchEnds, ASceneThatIsDeletedEndsItsWatches) {
  start();
  const auto id = make_scene(*stub_, tip_request());
  Watch first(*stub_, watch_request(id)), second(*stub_, watch_request(id));
  EXPECT_TRUE(probe_->becomes("collided_watchers", 2));
  ASSERT_TRUE(delete_scene(*stub_, id).ok());
  for (Watch* watch : {&first, &second}) {
    const auto status = watch->wait_end();
    EXPECT_EQ(status.error_code(), grpc::NOT_FOUND);
    EXPECT_EQ(status.error_message(), "scene " + id + " was deleted");
  }
  EXPECT_TRUE(probe_->becomes("collided_watchers", 0));
  EXPECT_TRUE(probe_->streams_become(0));
  EXPECT_TRUE(probe_->becomes("collided_device_bytes", 0));
}

TEST_F(WatchEnds, AWatchDoesNotKeepItsScene) {
  start({"--lease-seconds", "0.3"});
  const auto id = make_scene(*stub_, tip_request());
  Watch watch(*stub_, watch_request(id));
  ASSERT_TRUE(watch.opened());
  EXPECT_EQ(watch.wait_end().error_code(), grpc::NOT_FOUND);
}

TEST_F(WatchEnds, ADaemonThatStopsEndsItAndDoesNotWaitForIt) {
  start();
  const auto id = make_scene(*stub_, tip_request());
  Watch watch(*stub_, watch_request(id));
  ASSERT_TRUE(watch.opened());
  daemon_->signal(SIGTERM);
  EXPECT_EQ(watch.wait_end().error_code(), grpc::UNAVAILABLE);
  EXPECT_EQ(daemon_->wait(std::chrono::seconds(20)), 0);
}

TEST_F(WatchEnds, AMessageLeftUnreadForTooLongEndsIt) {
  start({"--max-idle-seconds", "1"});
  constexpr uint32_t kSide = 200;
  const auto id = make_scene(*stub_, layers_request(kSide, 1000));
  auto reader = pb::CollisionService::NewStub(channel_to(daemon_->address(), 1));
  Watch watch(*reader, watch_request(id, [](auto& request) { request.add_position_meshes(0); }));
  ASSERT_TRUE(watch.opened());
  const std::string positions = pack_points(layer_points(kSide, kLayersApart));
  uint64_t frame = 0;
  EXPECT_TRUE(eventually("the watch ends", [&] {
    EXPECT_TRUE(detect(*stub_, id, layers_frame(++frame, positions)).ok());
    return probe_->metric("collided_watchers") == 0;
  }));
  expect_quota(watch.wait_end(), "max_idle_seconds", "scene:" + id);
}

TEST_F(WatchEnds, AWatchCountsAsAStreamOfItsClient) {
  start({"--max-streams-per-client", "2"});
  const auto id = make_scene(*stub_, tip_request());
  Watch first(*stub_, watch_request(id));
  Stream stream(*stub_, id);
  ASSERT_TRUE(first.opened() && stream.opened());
  expect_quota(refusal(id), "max_streams_per_client", "client:");
}

TEST_F(WatchEnds, RoomForItsMessagesMustFitTheScene) {
  start();
  auto request = layers_request(20);
  request.mutable_spec()->set_memory_budget_bytes(uint64_t{4} << 20);
  const auto id = make_scene(*stub_, request);
  std::vector<std::unique_ptr<Watch>> watches;
  const auto asking = watch_request(id, [](auto& more) { more.set_max_contacts_per_kind(8192); });
  do watches.push_back(std::make_unique<Watch>(*stub_, asking));
  while (watches.back()->opened() && watches.size() < 32);
  ASSERT_GT(watches.size(), 1u);
  ASSERT_FALSE(watches.back()->opened());
  EXPECT_EQ(watches.back()->wait_end().error_code(), grpc::RESOURCE_EXHAUSTED);
  EXPECT_EQ(probe_->metric("collided_watchers"), static_cast<double>(watches.size() - 1));
}

TEST_F(WatchEnds, OnlyTheOwnerMayWatch) {
  const TokensFile tokens({{"alice"}, {"bob"}});
  start({"--tokens-file", tokens.path()});
  auto alice = pb::CollisionService::NewStub(channel_as("alice", daemon_->address()));
  stub_ = pb::CollisionService::NewStub(channel_as("bob", daemon_->address()));
  const auto id = make_scene(*alice, tip_request());
  EXPECT_TRUE(Watch(*alice, watch_request(id)).opened());
  expect_field(refusal(id), grpc::NOT_FOUND, "scene_id");
  stub_ = pb::CollisionService::NewStub(daemon_->channel());
  EXPECT_EQ(refusal(id).error_code(), grpc::UNAUTHENTICATED);
}

TEST_F(WatchEnds, EveryBadFieldIsNamed) {
  start();
  const auto id = make_scene(*stub_, tip_request());
  expect_field(refusal("none"), grpc::NOT_FOUND, "scene_id");
  for (const double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity(), 1e-4, 1e7})
    expect_field(refusal(id, [&](auto& request) { request.set_max_frames_per_second(bad); }), grpc::INVALID_ARGUMENT,
                 "max_frames_per_second");
  expect_field(refusal(id, [](auto& request) { request.set_max_contacts_per_kind(8193); }), grpc::INVALID_ARGUMENT,
               "max_contacts_per_kind");
  expect_field(refusal(id,
                       [](auto& request) {
                         request.add_position_meshes(1);
                         request.add_position_meshes(2);
                       }),
               grpc::INVALID_ARGUMENT, "position_meshes[1]");
  expect_field(refusal(id,
                       [](auto& request) {
                         request.add_position_meshes(1);
                         request.add_position_meshes(1);
                       }),
               grpc::INVALID_ARGUMENT, "position_meshes[1]");
  expect_field(refusal(id, [](auto& request) { request.set_vertex_stride(1); }), grpc::INVALID_ARGUMENT,
               "vertex_stride");
  EXPECT_TRUE(detect(*stub_, id, first_frame(2)).ok());
  EXPECT_TRUE(probe_->streams_become(0));
}

TEST_F(WatchEnds, AStrideIsRefusedWhosePositionsDoNotFitAMessage) {
  start();
  constexpr uint32_t kSide = 320;  // 204,800 vertices: 2,457,600 bytes
  const auto id = make_scene(*stub_, layers_request(kSide));
  const auto with_stride = [](uint32_t stride) {
    return [stride](pb::WatchSceneRequest& request) {
      request.add_position_meshes(0);
      request.set_vertex_stride(stride);
    };
  };
  const auto status = refusal(id, with_stride(1));
  expect_field(status, grpc::INVALID_ARGUMENT, "vertex_stride");
  EXPECT_NE(status.error_message().find("2 or more"), std::string::npos) << status.error_message();
  EXPECT_EQ(Watch(*stub_, watch_request(id, with_stride(0))).opened()->vertex_stride(), 2u);
  EXPECT_EQ(Watch(*stub_, watch_request(id, with_stride(2))).opened()->vertex_stride(), 2u);
}

}  // namespace
}  // namespace collided::test
