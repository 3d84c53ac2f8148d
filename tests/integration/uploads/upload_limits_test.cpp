// Memory of uploads and declared sizes: nothing past the limits, nothing for a declared number, nothing forever.
#include <gtest/gtest.h>

#include <list>
#include <optional>

#include "tests/integration/support/bystander.hpp"
#include "tests/integration/support/upload.hpp"

namespace collided::test {
namespace {

constexpr double kMebi = 1 << 20;

// The floor awaits its triangles.
pb::CreateSceneRequest awaiting(uint32_t triangles, double lease_seconds = 60) {
  auto request = tip_request();
  request.set_lease_seconds(lease_seconds);
  auto* floor = request.mutable_spec()->mutable_meshes(0);
  floor->clear_triangles();
  floor->set_triangle_count(triangles);
  return request;
}

// 41 bytes on the wire.
pb::CreateSceneRequest of_declared_vertices(uint32_t vertices) {
  auto request = tip_request(true);
  request.mutable_spec()->mutable_meshes(1)->set_vertex_count(vertices);
  return request;
}

class UploadLimits : public testing::Test {
 protected:
  void start(const std::vector<std::string>& more) {
    daemon_.emplace(more);
    probe_.emplace(*daemon_);
    stub_ = pb::CollisionService::NewStub(channel_to(daemon_->address(), 1));
    EXPECT_TRUE(list_scenes(*stub_).empty());  // its connection belongs to the baseline
  }

  std::optional<DaemonProcess> daemon_;
  std::optional<Probe> probe_;
  std::unique_ptr<Stub> stub_;
};

TEST_F(UploadLimits, OpenUploadsStayWithinTheDaemonsBytes) {
  constexpr double kLimit = 64 * kMebi;
  constexpr uint32_t kTriangles = 200'000;  // 2.3 MiB per upload
  start({"--max-device-mb", "64", "--max-device-mb-per-client", "16384", "--max-scene-mb", "16384",
         "--max-scenes-per-client", "64", "--max-silent-seconds", "600"});  // longer than a busy machine needs
  Aftermath aftermath(*probe_, daemon_->address());
  expect_quota(create_scene(*stub_, awaiting(36'000'000)), "max_device_bytes", "daemon");
  const double before = probe_->resident_bytes();
  std::list<Upload> open;
  std::vector<std::string> scenes;
  const auto triangles = many_triangles(kTriangles - 1);  // one is missing, so that it stays open
  for (int i = 0; i < 30; ++i) {
    scenes.push_back(make_scene(*stub_, awaiting(kTriangles)));
    open.emplace_back(*stub_, scenes.back(), triangles);
  }
  eventually("the uploads are counted", [&] { return probe_->device_bytes() > 0.9 * kLimit; });
  EXPECT_LE(probe_->device_bytes(), kLimit);
  EXPECT_LT(probe_->resident_bytes() - before, memory_limit(64 + 128));
  aftermath.bystander().expect_served();
  int refused = 0;
  for (auto& upload : open) {
    const auto status = upload.finish();
    if (status.error_code() == grpc::INVALID_ARGUMENT) continue;  // one is missing
    expect_quota(status, "max_device_bytes", "daemon");
    ++refused;
  }
  EXPECT_GT(refused, 0);
  for (const auto& id : scenes) EXPECT_TRUE(delete_scene(*stub_, id).ok());
  aftermath.expect_unharmed();
}

TEST_F(UploadLimits, EveryWayOutGivesBack) {
  start({});
  const auto id = make_scene(*stub_, awaiting(100'000));
  const double before = probe_->device_bytes();
  const auto many = many_triangles(50'000);
  const auto is_counted = [&] {
    return eventually("the upload is counted", [&] { return probe_->device_bytes() >= before + 50'000 * 12; });
  };
  {
    Upload cancelled(*stub_, id, many);
    is_counted();
    EXPECT_EQ(cancelled.cancel().error_code(), grpc::CANCELLED);
  }
  EXPECT_TRUE(probe_->becomes("collided_device_bytes", before));
  Upload incomplete(*stub_, id, many);
  is_counted();
  EXPECT_EQ(incomplete.finish().error_code(), grpc::INVALID_ARGUMENT);
  EXPECT_TRUE(probe_->becomes("collided_device_bytes", before));
  Upload deleted(*stub_, id, many);
  is_counted();
  EXPECT_TRUE(delete_scene(*stub_, id).ok());
  const auto status = deleted.wait_end();
  EXPECT_EQ(status.error_code(), grpc::NOT_FOUND) << status.error_message();
  EXPECT_NE(status.error_message().find("was deleted"), std::string::npos) << status.error_message();
  EXPECT_TRUE(probe_->becomes("collided_device_bytes", 0));
}

TEST_F(UploadLimits, ASilentUploadEndsAndThenItsSceneDoes) {
  start({"--max-idle-seconds", "0.5"});
  const auto id = make_scene(*stub_, awaiting(2, 0.5));
  Upload silent(*stub_, id, many_triangles(1));
  const auto status = silent.wait_end();
  EXPECT_EQ(status.error_code(), grpc::DEADLINE_EXCEEDED);
  EXPECT_NE(status.error_message().find("no chunk of the upload arrived for 0.5 s"), std::string::npos)
      << status.error_message();
  EXPECT_TRUE(probe_->scenes_become(0));
  EXPECT_TRUE(probe_->becomes("collided_device_bytes", 0));
  const auto gone = get_scene(*stub_, id);
  EXPECT_EQ(gone.error_code(), grpc::NOT_FOUND);
  EXPECT_NE(gone.error_message().find("its lease of 0.5 s ran out"), std::string::npos) << gone.error_message();
}

TEST_F(UploadLimits, AnUploadIsOneOfTheClientsStreams) {
  start({"--max-streams-per-client", "1"});
  const auto one = make_scene(*stub_, awaiting(2)), other = make_scene(*stub_, awaiting(2));
  {
    Upload open(*stub_, one, many_triangles(1));
    EXPECT_TRUE(probe_->streams_become(1));
    expect_quota(Upload(*stub_, other, many_triangles(2)).finish(), "max_streams_per_client", "client:");
    open.cancel();
  }
  EXPECT_TRUE(probe_->streams_become(0));
  EXPECT_TRUE(Upload(*stub_, other, many_triangles(2)).finish().ok());
}

TEST_F(UploadLimits, WhatCanNeverFitIsRefusedWithNeedAndBudgetHoweverItComes) {
  start({"--max-scene-mb", "10"});
  const auto status = create_scene(*stub_, awaiting(100'000'000));
  expect_field(status, grpc::RESOURCE_EXHAUSTED, "spec.memory_budget_bytes");
  EXPECT_NE(status.error_message().find("is 10485760 (max_scene_bytes)"), std::string::npos) << status.error_message();
  EXPECT_NE(status.error_message().find("100000001 triangles of spec.meshes need at least"), std::string::npos)
      << status.error_message();
  constexpr uint32_t kTriangles = 100'000;
  auto with_triangles = awaiting(kTriangles);
  with_triangles.mutable_spec()->mutable_meshes(0)->set_triangles(pack(many_triangles(kTriangles)));
  const auto later = create_scene(*stub_, awaiting(kTriangles)), at_once = create_scene(*stub_, with_triangles);
  EXPECT_EQ(later.error_code(), grpc::RESOURCE_EXHAUSTED);
  EXPECT_EQ(later.error_message(), at_once.error_message());
  EXPECT_EQ(probe_->device_bytes(), 0);
}

// Frames could use shared memory here; with gRPC only, the requests are refused.
TEST_F(UploadLimits, DeclaredVerticesReserveNothing) {
  const std::string socket = testing::TempDir() + "collided-declared-" + std::to_string(getpid());
  start({"--local-socket", socket, "--max-scene-mb", "16384", "--max-device-mb", "65536", "--max-device-mb-per-client",
         "65536"});
  std::vector<std::string> scenes;
  for (int i = 0; i < 14; ++i) scenes.push_back(make_scene(*stub_, of_declared_vertices(63'999'997)));
  EXPECT_GT(probe_->device_bytes(), 0);
  EXPECT_LT(probe_->device_bytes(), kMebi);
  for (const auto& id : scenes) EXPECT_TRUE(delete_scene(*stub_, id).ok());
  EXPECT_EQ(probe_->device_bytes(), 0);
}

TEST_F(UploadLimits, ASceneWhoseFirstFrameCannotBeSentIsRefused) {
  start({"--max-message-mb", "1"});
  const auto status = create_scene(*stub_, of_declared_vertices(50'000));
  expect_field(status, grpc::RESOURCE_EXHAUSTED, "spec.meshes");
  EXPECT_NE(status.error_message().find("50003 vertices, whose positions, 1200072 bytes,"), std::string::npos)
      << status.error_message();
  EXPECT_NE(status.error_message().find("max-message-mb"), std::string::npos) << status.error_message();
  EXPECT_TRUE(create_scene(*stub_, of_declared_vertices(40'000)).ok());
}

TEST_F(UploadLimits, TriangleCountIsThatOfTheWholeMesh) {
  start({});
  auto request = tip_request();
  auto* floor = request.mutable_spec()->mutable_meshes(0);
  floor->set_triangle_count(1);
  const auto whole = made_scene(*stub_, request);
  EXPECT_EQ(whole.state(), pb::SCENE_STATE_READY);
  EXPECT_EQ(whole.triangle_count(), 2u);
  EXPECT_TRUE(detect(*stub_, whole.scene_id(), first_frame(2)).ok());
  floor->set_triangle_count(3);
  const auto rest = made_scene(*stub_, request);
  EXPECT_EQ(rest.state(), pb::SCENE_STATE_AWAITING_MESHES);
  EXPECT_EQ(rest.triangle_count(), 4u);
  const auto early = detect(*stub_, rest.scene_id(), first_frame(2));
  EXPECT_EQ(early.error_code(), grpc::FAILED_PRECONDITION);
  EXPECT_NE(early.error_message().find("mesh 0 (\"floor\") awaits 2 of its 3 triangles; send them with UploadMesh"),
            std::string::npos)
      << early.error_message();
  EXPECT_TRUE(Upload(*stub_, rest.scene_id(), many_triangles(2)).finish().ok());
  EXPECT_TRUE(detect(*stub_, rest.scene_id(), first_frame(2)).ok());
  floor->set_triangles(pack(many_triangles(2)));
  floor->set_triangle_count(1);
  expect_field(create_scene(*stub_, request), grpc::INVALID_ARGUMENT, "spec.meshes[0].triangle_count");
}

}  // namespace
}  // namespace collided::test
