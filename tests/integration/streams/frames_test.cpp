// Frames with known contacts, by streams and single calls.
#include <gtest/gtest.h>

#include <thread>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

class Frames : public testing::Test {
 protected:
  DaemonProcess daemon_;
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

void stream_ten_frames(Stub& stub, bool wide) {
  Stream stream(stub, make_scene(stub, tip_request(wide)));
  ASSERT_TRUE(stream.opened());
  EXPECT_EQ(stream.opened()->window(), 2u);
  for (int i = 0; i < 10; ++i) {
    const double depth = 1.25 + 0.25 * i;
    expect_tip_contact(stream.ask(i == 0 ? first_frame(depth, wide) : tip_frame(i + 1, depth, wide)), depth);
  }
  EXPECT_TRUE(stream.finish().ok());
}

TEST_F(Frames, TenFramesInSinglePrecision) { stream_ten_frames(*stub_, false); }

TEST_F(Frames, TenFramesInDoublePrecision) { stream_ten_frames(*stub_, true); }

TEST_F(Frames, TwoStreamsAtOnce) {
  std::thread other([&] { stream_ten_frames(*stub_, true); });
  stream_ten_frames(*stub_, false);
  other.join();
}

TEST_F(Frames, AFrameThatDoesNotReachTheFloorHasNoContact) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  const Answer answer = stream.ask(first_frame(0.5));
  ASSERT_TRUE(answer.done);
  EXPECT_EQ(answer.done->contact_count(), 0u);
  EXPECT_EQ(answer.done->earliest_toi(), 1);
  EXPECT_TRUE(answer.chunks.empty());
}

// Without start positions a mesh moves from where the last frame left it.
TEST_F(Frames, FramesContinueTheMotion) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  ASSERT_TRUE(stream.ask(first_frame(0)).done);
  auto frame = tip_frame(2, 2);
  frame.mutable_updates(0)->clear_start_positions();
  expect_tip_contact(stream.ask(frame), 2);
}

TEST_F(Frames, DiscreteDetectionFindsACornerWithinTheThickness) {
  auto request = tip_request();
  request.mutable_spec()->set_mode(pb::DETECTION_MODE_DCD);
  request.mutable_spec()->set_thickness(0.25);
  Stream stream(*stub_, make_scene(*stub_, request));
  auto frame = first_frame(0.875);  // the tip ends at z = 0.125
  frame.mutable_updates(0)->clear_start_positions();
  const Answer answer = stream.ask(frame);
  ASSERT_TRUE(answer.done) << (answer.error ? answer.error->message() : "ended");
  ASSERT_EQ(answer.chunks.size(), 1u);
  EXPECT_EQ(answer.chunks[0].elements(), pack<uint32_t>({3, 0}));
  EXPECT_EQ(answer.chunks[0].distance(), pack<double>({0.125}));
  EXPECT_TRUE(answer.chunks[0].toi().empty());
}

// From GUARDED on a thickness of 0 means touching.
TEST_F(Frames, DiscreteDetectionFindsACornerThatTouches) {
  auto request = tip_request();
  request.mutable_spec()->set_mode(pb::DETECTION_MODE_DCD);
  Stream stream(*stub_, make_scene(*stub_, request));
  auto frame = first_frame(1);
  frame.mutable_updates(0)->clear_start_positions();
  const Answer answer = stream.ask(frame);
  ASSERT_TRUE(answer.done) << (answer.error ? answer.error->message() : "ended");
  ASSERT_EQ(answer.chunks.size(), 1u);
  EXPECT_EQ(answer.chunks[0].elements(), pack<uint32_t>({3, 0}));
}

TEST_F(Frames, EveryEngineFindsTheContactAndNamesItself) {
  for (int engine = pb::BroadPhaseEngine_MIN; engine <= pb::BroadPhaseEngine_MAX; ++engine) {
    auto request = tip_request();
    request.mutable_spec()->set_broad_phase_engine(static_cast<pb::BroadPhaseEngine>(engine));
    Stream stream(*stub_, make_scene(*stub_, request));
    ASSERT_TRUE(stream.opened());
    EXPECT_EQ(stream.opened()->scene().spec().broad_phase_engine(), engine);
    const Answer answer = stream.ask(first_frame(2));
    expect_tip_contact(answer, 2);
    EXPECT_NE(answer.done->metrics().broad_phase_engine(), pb::BROAD_PHASE_ENGINE_UNSPECIFIED);
    EXPECT_GT(answer.done->metrics().step_milliseconds(), 0);
    EXPECT_EQ(answer.done->metrics().graph_launches() > 0, test_backend() == "cuda");
  }
}

TEST_F(Frames, TrianglesThatCrossAreFound) {
  auto request = tip_request();
  request.mutable_spec()->set_mode(pb::DETECTION_MODE_DCD);
  request.mutable_spec()->add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
  Stream stream(*stub_, make_scene(*stub_, request));
  auto frame = first_frame(2);  // the tip ends below the floor
  frame.mutable_updates(0)->clear_start_positions();
  const Answer answer = stream.ask(frame);
  ASSERT_TRUE(answer.done) << (answer.error ? answer.error->message() : "ended");
  EXPECT_TRUE(answer.done->any_contact());
  EXPECT_EQ(answer.done->contact_count(), 1u);
  ASSERT_EQ(answer.chunks.size(), 1u);
  const auto& chunk = answer.chunks[0];
  EXPECT_EQ(chunk.kind(), pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
  EXPECT_EQ(chunk.elements(), pack<uint32_t>({0, 1}));
  EXPECT_EQ(chunk.flags().size(), 1u);
  EXPECT_TRUE(chunk.stencils().empty() && chunk.toi().empty() && chunk.distance().empty());
}

TEST_F(Frames, FramesInFlightAreAnsweredInOrder) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()), 16);
  stream.send(first_frame(2));
  for (uint64_t id = 2; id <= 16; ++id) stream.send(tip_frame(id, 1 + 0.5 * id));
  expect_tip_contact(stream.receive(1), 2);
  for (uint64_t id = 2; id <= 16; ++id) expect_tip_contact(stream.receive(id), 1 + 0.5 * id);
}

// A client that sends more than its credits is held back, not harmed.
TEST_F(Frames, MoreFramesThanCredits) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()), 1);
  stream.send(first_frame(2));
  for (uint64_t id = 2; id <= 50; ++id) stream.send(tip_frame(id, 2));
  for (uint64_t id = 1; id <= 50; ++id) expect_tip_contact(stream.receive(id), 2);
}

TEST_F(Frames, DetectFrameAnswersInOneMessage) {
  pb::DetectFrameResponse response;
  const auto status = detect(*stub_, make_scene(*stub_, tip_request()), first_frame(2), &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  expect_tip_contact({response.contacts().begin(), response.contacts().end()}, response.done(), 2);
  EXPECT_GT(response.done().metrics().stages_size(), 0);
  EXPECT_EQ(response.done().metrics().bytes_in(), 9u * 12);
  EXPECT_EQ(response.done().metrics().bytes_out(), 41u);
}

TEST_F(Frames, AClientThatGivesUpLeavesTheSceneUnharmed) {
  const pb::Scene scene = made_scene(*stub_, tip_request());
  {
    Stream stream(*stub_, scene.scene_id());
    ASSERT_TRUE(stream.ask(first_frame(2)).done);
    stream.send(tip_frame(2, 2));
    stream.cancel();
    EXPECT_EQ(stream.finish().error_code(), grpc::CANCELLED);
  }
  // The client may know that it gave up before the daemon does.
  Stream stream(*stub_, scene.scene_id(), 0, scene.resume_token());
  ASSERT_TRUE(stream.opened());
  expect_tip_contact(stream.ask(tip_frame(3, 3)), 3);
}

}  // namespace
}  // namespace collided::test
