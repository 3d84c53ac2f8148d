// Scenes are created, filled, listed, described and deleted.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

class Scenes : public testing::Test {
 protected:
  DaemonProcess daemon_;
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

TEST_F(Scenes, UploadedTrianglesMakeTheSceneReady) {
  auto request = tip_request();
  request.mutable_spec()->mutable_meshes(0)->clear_triangles();
  request.mutable_spec()->mutable_meshes(0)->set_triangle_count(1);
  const auto id = make_scene(*stub_, request);
  EXPECT_FALSE(Stream(*stub_, id).opened());
  grpc::ClientContext context;
  set_deadline(context);
  pb::UploadMeshResponse response;
  auto upload = stub_->UploadMesh(&context, &response);
  pb::UploadMeshRequest chunk;
  chunk.set_scene_id(id);
  chunk.set_triangles(pack<uint32_t>({0, 1, 2}));
  upload->Write(chunk);
  upload->WritesDone();
  const auto status = upload->Finish();
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.scene().state(), pb::SCENE_STATE_READY);
  Stream stream(*stub_, id);
  expect_tip_contact(stream.ask(first_frame(2)), 2);
}

TEST_F(Scenes, ScenesAreListedInPagesAndDeleted) {
  for (int i = 0; i < 5; ++i) make_scene(*stub_, tip_request());
  std::vector<std::string> ids;
  pb::ListScenesRequest request;
  request.set_page_size(2);
  do {
    grpc::ClientContext context;
    set_deadline(context);
    pb::ListScenesResponse response;
    ASSERT_TRUE(stub_->ListScenes(&context, request, &response).ok());
    EXPECT_LE(response.scenes_size(), 2);
    for (const auto& scene : response.scenes()) ids.push_back(scene.scene_id());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  ASSERT_EQ(ids.size(), 5u);
  EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end()));
  Stream stream(*stub_, ids[0]);
  EXPECT_TRUE(delete_scene(*stub_, ids[0]).ok());
  EXPECT_EQ(delete_scene(*stub_, ids[0]).error_code(), grpc::NOT_FOUND);
  EXPECT_TRUE(stream.ask(first_frame(2)).ended);
  EXPECT_EQ(stream.finish().error_code(), grpc::NOT_FOUND);
}

TEST_F(Scenes, GetSceneShowsWhatItHolds) {
  const auto id = make_scene(*stub_, tip_request());
  Stream stream(*stub_, id);
  ASSERT_TRUE(stream.ask(first_frame(2)).done);
  pb::Scene scene;
  ASSERT_TRUE(get_scene(*stub_, id, &scene).ok());
  EXPECT_EQ(scene.state(), pb::SCENE_STATE_READY);
  EXPECT_EQ(scene.vertex_count(), 6u);
  EXPECT_EQ(scene.edge_count(), 6u);
  EXPECT_EQ(scene.triangle_count(), 2u);
  EXPECT_EQ(scene.last_frame_id(), 1u);
  EXPECT_EQ(scene.spec().accuracy(), pb::ACCURACY_CERTIFIED);
  EXPECT_EQ(scene.spec().report(), pb::REPORT_ALL);
  EXPECT_GT(scene.memory_size(), 0);
}

TEST_F(Scenes, ServerInfoNamesVersionAndDevices) {
  grpc::ClientContext context;
  set_deadline(context);
  pb::GetServerInfoResponse response;
  ASSERT_TRUE(stub_->GetServerInfo(&context, {}, &response).ok());
  EXPECT_EQ(response.version(), COLLIDED_VERSION);
  ASSERT_GT(response.devices_size(), 0);
  EXPECT_EQ(response.devices(0).backend(), test_backend() == "cuda" ? pb::BACKEND_CUDA : pb::BACKEND_CPU);
  EXPECT_EQ(response.limits().max_message_bytes(), 64u << 20);
}

}  // namespace
}  // namespace collided::test
