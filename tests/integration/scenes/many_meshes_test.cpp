// Scenes of many meshes fit the messages that describe them.
#include <gtest/gtest.h>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

pb::CreateSceneRequest many_meshes(int count) {
  auto request = tip_request();
  const auto mesh = request.spec().meshes(1);
  request.mutable_spec()->clear_meshes();
  for (int i = 0; i < count; ++i) {
    auto* added = request.mutable_spec()->add_meshes();
    *added = mesh;
    added->set_name(std::to_string(i) + std::string(120, '-'));
  }
  return request;
}

TEST(ManyMeshes, TheLargestSceneFitsItsAnswer) {
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  EXPECT_NE(make_scene(*stub, many_meshes(16384)), "");
  const auto status = create_scene(*stub, many_meshes(16385));
  EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED);
  EXPECT_NE(status.error_message().find("16385"), std::string::npos) << status.error_message();
}

TEST(ManyMeshes, APageOfScenesEndsBeforeItsMessageIsTooLarge) {
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  for (int i = 0; i < 5; ++i) make_scene(*stub, many_meshes(7500));
  int scenes = 0, pages = 0;
  pb::ListScenesRequest request;
  do {
    grpc::ClientContext context;
    set_deadline(context);
    pb::ListScenesResponse response;
    const auto status = stub->ListScenes(&context, request, &response);
    ASSERT_TRUE(status.ok()) << status.error_message();
    scenes += response.scenes_size();
    ++pages;
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_EQ(scenes, 5);
  EXPECT_GT(pages, 1);
}

}  // namespace
}  // namespace collided::test
