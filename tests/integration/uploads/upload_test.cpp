// Uploads that end early, have too few triangles, or form no valid scene.
#include "tests/integration/support/upload.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

constexpr auto kPause = std::chrono::milliseconds(100);  // for a message to arrive

class Uploads : public testing::Test {
 protected:
  // The floor has two triangles, sent by an upload.
  static pb::CreateSceneRequest awaiting_request() {
    auto request = tip_request();
    auto* floor = request.mutable_spec()->mutable_meshes(0);
    floor->clear_triangles();
    floor->set_vertex_count(6);
    floor->set_triangle_count(2);
    return request;
  }

  // The budget that CreateScene names as the minimum; building the scene takes a little more.
  uint64_t least_budget(pb::CreateSceneRequest request) {
    request.mutable_spec()->set_memory_budget_bytes(1);
    const std::string why = create_scene(*stub_, request).error_message(), before = "at least ";
    const auto at = why.find(before);
    EXPECT_NE(at, std::string::npos) << why;
    return at == std::string::npos ? 1 : std::stoull(why.substr(at + before.size()));
  }

  pb::SceneState state(const std::string& id) {
    pb::Scene scene;
    EXPECT_TRUE(get_scene(*stub_, id, &scene).ok());
    return scene.state();
  }

  const std::vector<uint32_t> all_ = {0, 1, 2, 3, 4, 5}, half_ = {0, 1, 2};
  DaemonProcess daemon_;
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

TEST_F(Uploads, AnUploadThatEndsEarlyChangesNothing) {
  const auto id = make_scene(*stub_, awaiting_request());
  for (const auto& triangles : {std::vector<uint32_t>(), half_}) {
    const auto status = Upload(*stub_, id, triangles).finish();
    EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT);
    EXPECT_NE(status.error_message().find("of 2 triangles"), std::string::npos) << status.error_message();
  }
  EXPECT_EQ(state(id), pb::SCENE_STATE_AWAITING_MESHES);
  EXPECT_TRUE(Upload(*stub_, id, all_).finish().ok());
  EXPECT_EQ(state(id), pb::SCENE_STATE_READY);
}

TEST_F(Uploads, AMeshTakesOneUploadAtATime) {
  const auto id = make_scene(*stub_, awaiting_request());
  Upload slow(*stub_, id, {});
  std::this_thread::sleep_for(kPause);
  EXPECT_EQ(Upload(*stub_, id, all_).finish().error_code(), grpc::FAILED_PRECONDITION);
  EXPECT_EQ(slow.finish().error_code(), grpc::INVALID_ARGUMENT);
  EXPECT_TRUE(Upload(*stub_, id, all_).finish().ok());
  EXPECT_EQ(state(id), pb::SCENE_STATE_READY);
}

TEST_F(Uploads, ACancelledUploadChangesNothing) {
  const auto id = make_scene(*stub_, awaiting_request());
  for (const auto& triangles : {half_, all_}) {
    Upload upload(*stub_, id, triangles);
    std::this_thread::sleep_for(kPause);
    EXPECT_EQ(upload.cancel().error_code(), grpc::CANCELLED);
    std::this_thread::sleep_for(kPause);
    EXPECT_EQ(state(id), pb::SCENE_STATE_AWAITING_MESHES);
  }
  EXPECT_TRUE(Upload(*stub_, id, all_).finish().ok());
}

TEST_F(Uploads, ABadTriangleIsRefusedBeforeItCounts) {
  const auto id = make_scene(*stub_, awaiting_request());
  for (const auto& triangles : {std::vector<uint32_t>{0, 1, 2, 3, 4, 4}, {0, 1, 2, 3, 4, 6}}) {
    const auto status = Upload(*stub_, id, triangles).finish();
    EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT);
    EXPECT_TRUE(status.error_message().starts_with("triangles[1] ")) << status.error_message();
    EXPECT_TRUE(status.error_message().ends_with(", in mesh 0 (\"floor\")")) << status.error_message();
  }
  EXPECT_TRUE(Upload(*stub_, id, all_).finish().ok());
  EXPECT_EQ(state(id), pb::SCENE_STATE_READY);
}

TEST_F(Uploads, ASceneThatCannotBeMadeIsDeleted) {
  auto request = awaiting_request();
  request.mutable_spec()->set_memory_budget_bytes(least_budget(request) + 500);  // and what the spec itself takes
  const auto id = make_scene(*stub_, request);
  const auto status = Upload(*stub_, id, all_).finish();
  EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED);
  EXPECT_NE(status.error_details().find("spec.memory_budget_bytes"), std::string::npos) << status.error_message();
  EXPECT_EQ(get_scene(*stub_, id).error_code(), grpc::NOT_FOUND);
}

}  // namespace
}  // namespace collided::test
