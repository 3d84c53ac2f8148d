// One stream per scene: who may take over, what a new stream is told, and that it continues exactly where the old one
// ended.
#include <gtest/gtest.h>

#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

class Resume : public testing::Test {
 protected:
  DaemonProcess daemon_;
  Probe probe_{daemon_};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
  const pb::Scene scene_ = made_scene(*stub_, tip_request());
  const std::string id_ = scene_.scene_id(), token_ = scene_.resume_token();
};

// Moves only the tip's lowest corner, from where it is.
pb::Frame corner_frame(uint64_t id, double z) {
  pb::Frame frame;
  frame.set_frame_id(id);
  auto* tip = frame.add_updates();
  tip->set_mesh(1);
  tip->mutable_sparse()->set_indices(pack<uint32_t>({0}));
  tip->set_positions(pack_points({{0, 0, z}}));
  return frame;
}

TEST_F(Resume, TheTokenIsSecretAndNotEmpty) {
  EXPECT_GE(token_.size(), 16u);
  EXPECT_NE(token_, id_);
  EXPECT_NE(token_, made_scene(*stub_, tip_request()).resume_token());
}

TEST_F(Resume, ASecondStreamWithoutATokenIsRefused) {
  Stream stream(*stub_, id_);
  expect_tip_contact(stream.ask(first_frame(2)), 2);
  expect_field(Stream(*stub_, id_).finish(), grpc::FAILED_PRECONDITION, "open.resume_token");
  expect_tip_contact(stream.ask(tip_frame(2, 3)), 3);
}

TEST_F(Resume, AWrongTokenIsRefused) {
  Stream stream(*stub_, id_);
  for (const auto& token : {std::string("x"), token_ + "0", token_.substr(1), std::string(1 << 20, 'y')}) {
    const auto status = Stream(*stub_, id_, 0, token).finish();
    expect_field(status, grpc::PERMISSION_DENIED, "open.resume_token");
    EXPECT_EQ(status.error_message().find(token_), std::string::npos);
    EXPECT_LT(status.error_message().size(), 1000u);
  }
  expect_tip_contact(stream.ask(first_frame(2)), 2);
}

TEST_F(Resume, ATakeOverEndsTheOldStreamAndTellsTheLastFrame) {
  Stream old(*stub_, id_);
  expect_tip_contact(old.ask(first_frame(2)), 2);
  expect_tip_contact(old.ask(tip_frame(7, 2)), 2);
  Stream next(*stub_, id_, 3, token_);
  ASSERT_TRUE(next.opened());
  EXPECT_EQ(next.opened()->scene().last_frame_id(), 7u);
  EXPECT_EQ(next.opened()->scene().resume_token(), token_);
  EXPECT_EQ(next.opened()->window(), 3u);
  expect_field(old.wait_end(), grpc::ABORTED, "open.scene_id");
  expect_tip_contact(next.ask(tip_frame(8, 3)), 3);
  EXPECT_TRUE(probe_.streams_become(1));
  EXPECT_EQ(probe_.metric("collided_reconnects_total"), 1);
}

// The old stream may be of a connection that broke without a word: it is in nobody's way.
TEST(ResumeAtTheLimit, TakesThePlaceOfTheStreamThatItEnds) {
  const DaemonProcess daemon({"--max-streams-per-client", "1"});
  const auto stub = pb::CollisionService::NewStub(daemon.channel());
  const pb::Scene scene = made_scene(*stub, tip_request());
  Stream old(*stub, scene.scene_id());
  expect_tip_contact(old.ask(first_frame(2)), 2);
  EXPECT_EQ(Stream(*stub, make_scene(*stub, tip_request())).finish().error_code(), grpc::RESOURCE_EXHAUSTED);
  EXPECT_EQ(Stream(*stub, scene.scene_id()).finish().error_code(), grpc::RESOURCE_EXHAUSTED);  // without the token
  Stream next(*stub, scene.scene_id(), 0, scene.resume_token());
  ASSERT_TRUE(next.opened());
  expect_field(old.wait_end(), grpc::ABORTED, "open.scene_id");
  expect_tip_contact(next.ask(tip_frame(2, 3)), 3);
}

// A client may resume only to learn which frame was the last.
TEST_F(Resume, AStreamThatIsHalfClosedAtOnceIsToldThatItIsOpen) {
  for (int i = 0; i < 100; ++i) {
    grpc::ClientContext context;
    set_deadline(context);
    const auto call = stub_->StreamFrames(&context);
    pb::StreamFramesRequest request;
    request.mutable_open()->set_scene_id(id_);
    request.mutable_open()->set_resume_token(token_);
    call->WriteLast(request, {});
    pb::StreamFramesResponse response;
    ASSERT_TRUE(call->Read(&response)) << i;
    EXPECT_TRUE(response.has_opened());
    EXPECT_FALSE(call->Read(&response));
    EXPECT_TRUE(call->Finish().ok());
  }
}

// A frame is applied or dropped, and the new stream is told which.
TEST_F(Resume, ATakeOverWithFramesInFlightIsExact) {
  Stream old(*stub_, id_, 16);
  old.send(first_frame(2));
  for (uint64_t id = 2; id <= 16; ++id) old.send(tip_frame(id, 2));
  Stream next(*stub_, id_, 16, token_);
  ASSERT_TRUE(next.opened());
  const uint64_t last = next.opened()->scene().last_frame_id();
  EXPECT_LE(last, 16u);
  expect_tip_contact(next.ask(last == 0 ? first_frame(3) : tip_frame(last + 1, 3)), 3);
  pb::Scene scene;
  ASSERT_TRUE(get_scene(*stub_, id_, &scene).ok());
  EXPECT_EQ(scene.last_frame_id(), last + 1);
}

TEST_F(Resume, ABrokenStreamWithSparseUpdatesGoesOn) {
  {
    Stream stream(*stub_, id_);
    EXPECT_EQ(stream.ask(first_frame(0.25)).done->contact_count(), 0u);  // the corner ends at z = 0.75
    EXPECT_EQ(stream.ask(corner_frame(2, 0.5)).done->contact_count(), 0u);
    stream.cancel();
    EXPECT_EQ(stream.wait_end().error_code(), grpc::CANCELLED);
  }
  Stream next(*stub_, id_, 0, token_);
  ASSERT_TRUE(next.opened());
  EXPECT_EQ(next.opened()->scene().last_frame_id(), 2u);
  const Answer stale = next.ask(corner_frame(2, 0));
  ASSERT_TRUE(stale.error);
  EXPECT_EQ(stale.error->code(), grpc::FAILED_PRECONDITION);
  expect_tip_contact(next.ask(corner_frame(3, -0.5)), 2);  // from 0.5 to -0.5
  expect_tip_contact(next.ask(tip_frame(4, 4)), 4);
}

TEST_F(Resume, WithoutAStreamATokenIsOfNoHarmAndNoneIsNeeded) {
  {
    Stream stream(*stub_, id_, 0, token_);
    expect_tip_contact(stream.ask(first_frame(2)), 2);
  }
  EXPECT_TRUE(probe_.streams_become(0));
  Stream stream(*stub_, id_);
  ASSERT_TRUE(stream.opened());
  EXPECT_EQ(stream.opened()->scene().last_frame_id(), 1u);
  expect_tip_contact(stream.ask(tip_frame(2, 2)), 2);
}

TEST_F(Resume, WhileAStreamIsOpenItAloneBringsFrames) {
  Stream stream(*stub_, id_);
  expect_tip_contact(stream.ask(first_frame(2)), 2);
  expect_field(detect(*stub_, id_, tip_frame(2, 2)), grpc::FAILED_PRECONDITION, "scene_id");
  expect_tip_contact(stream.ask(tip_frame(2, 3)), 3);
  EXPECT_TRUE(stream.finish().ok());
  EXPECT_TRUE(probe_.streams_become(0));
  pb::DetectFrameResponse response;
  EXPECT_TRUE(detect(*stub_, id_, tip_frame(3, 2), &response).ok());
  expect_tip_contact({response.contacts().begin(), response.contacts().end()}, response.done(), 2);
}

TEST_F(Resume, ADeletedSceneEndsItsStreamAndFreesItsMemory) {
  Stream stream(*stub_, id_);
  expect_tip_contact(stream.ask(first_frame(2)), 2);
  EXPECT_GT(probe_.device_bytes(), 0);
  EXPECT_TRUE(delete_scene(*stub_, id_).ok());
  EXPECT_EQ(probe_.device_bytes(), 0);
  EXPECT_EQ(probe_.scenes(), 0);
  const auto status = stream.wait_end();
  EXPECT_EQ(status.error_code(), grpc::NOT_FOUND);
  EXPECT_NE(status.error_message().find(id_), std::string::npos) << status.error_message();
  EXPECT_EQ(Stream(*stub_, id_, 0, token_).finish().error_code(), grpc::NOT_FOUND);
  EXPECT_TRUE(probe_.streams_become(0));
}

}  // namespace
}  // namespace collided::test
