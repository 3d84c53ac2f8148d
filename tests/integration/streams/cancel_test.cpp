// Cancelled calls stop their work, and leave the scene in its last good state.
#include <gtest/gtest.h>

#include "tests/integration/support/layers.hpp"
#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kSide = 250;

class Cancel : public testing::Test {
 protected:
  static pb::Frame frame(uint64_t id, double gap) { return layers_frame(id, pack_points(layer_points(kSide, gap))); }

  DaemonProcess daemon_;
  Probe probe_{daemon_};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

// How long a frame takes depends on what else the machine does: the deadline is half of that, and where a call comes
// too late to be begun at all, or is done in time, the next one is given longer, or less.
TEST_F(Cancel, ADeadlineEndsTheCallAndStopsTheWork) {
  if (test_backend() == "cuda") GTEST_SKIP() << "a GPU is done with the frame before the deadline";
  constexpr uint64_t kMaxTries = 20;
  const auto scene_id = make_scene(*stub_, layers_request(kSide));
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_TRUE(detect(*stub_, scene_id, frame(1, kLayersApart)).ok());
  auto deadline = std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - begin) / 2;
  uint64_t id = 1, answered = 1;
  while (probe_.rejected("CANCELLED") == 0 && ++id <= kMaxTries) {
    const auto late = detect(*stub_, scene_id, frame(id, kLayersApart), nullptr, deadline);
    if (late.ok()) answered = id;
    ASSERT_TRUE(late.ok() || late.error_code() == grpc::DEADLINE_EXCEEDED) << late.error_message();
    const bool is_given_up = holds_within(std::chrono::seconds(3), [&] { return probe_.rejected("CANCELLED") == 1; });
    if (!is_given_up) deadline = late.ok() ? deadline / 2 : deadline * 3 / 2;
  }
  ASSERT_EQ(probe_.rejected("CANCELLED"), 1) << "no frame was given up in " << kMaxTries << " tries";
  pb::Scene scene;
  ASSERT_TRUE(get_scene(*stub_, scene_id, &scene).ok());
  EXPECT_LT(scene.last_frame_id(), id);
  EXPECT_GE(scene.last_frame_id(), answered);
  pb::DetectFrameResponse response;
  ASSERT_TRUE(detect(*stub_, scene_id, frame(id, kLayersApart), &response).ok());
  EXPECT_EQ(response.done().contact_count(), 0u);
}

TEST_F(Cancel, ACancelledStreamStopsTheWork) {
  const auto id = make_scene(*stub_, layers_request(kSide));
  Stream stream(*stub_, id, 4);
  ASSERT_TRUE(stream.ask(frame(1, kLayersApart)).done);
  for (uint64_t frame_id = 2; frame_id <= 5; ++frame_id) stream.send(frame(frame_id, kLayersApart));
  stream.cancel();
  EXPECT_EQ(stream.finish().error_code(), grpc::CANCELLED);
  EXPECT_TRUE(probe_.streams_become(0));
  pb::Scene scene;
  ASSERT_TRUE(get_scene(*stub_, id, &scene).ok());
  EXPECT_LT(scene.last_frame_id(), 5u);
  EXPECT_TRUE(detect(*stub_, id, frame(6, kLayersApart)).ok());
}

// The running frame is abandoned, too: the memory is free once the call returns.
TEST_F(Cancel, ASceneThatIsDeletedWithinAFrameIsFreed) {
  const auto id = make_scene(*stub_, layers_request(kSide));
  Stream stream(*stub_, id, 4);
  for (uint64_t frame_id = 1; frame_id <= 4; ++frame_id) stream.send(frame(frame_id, kLayersApart));
  ASSERT_TRUE(stream.receive(1).done);
  EXPECT_GT(probe_.device_bytes(), 1e6);
  EXPECT_TRUE(delete_scene(*stub_, id).ok());
  EXPECT_EQ(probe_.device_bytes(), 0);
  EXPECT_EQ(stream.wait_end().error_code(), grpc::NOT_FOUND);
}

TEST_F(Cancel, AnAnswerThatIsTooLargeForOneMessageIsRefused) {
  const auto id = make_scene(*stub_, layers_request(120));
  const auto status = detect(*stub_, id, layers_frame(1, pack_points(layer_points(120))));
  expect_field(status, grpc::RESOURCE_EXHAUSTED, "frame");
  EXPECT_EQ(probe_.rejected("RESOURCE_EXHAUSTED"), 1);
  Stream stream(*stub_, id);
  ASSERT_TRUE(stream.opened());
  EXPECT_EQ(stream.opened()->scene().last_frame_id(), 1u);  // it was applied, as the message says
  EXPECT_GT(stream.ask(layers_frame(2, pack_points(layer_points(120)))).chunks.size(), 2u);
}

}  // namespace
}  // namespace collided::test
