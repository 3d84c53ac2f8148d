// LATEST_WINS: waiting frames give way to later ones that cover them, are reported in order, and no position that only
// one of them has is lost.
#include <gtest/gtest.h>

#include <set>

#include "tests/integration/support/layers.hpp"
#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kSide = 80;  // a frame takes longer than the next ones take to arrive
constexpr uint64_t kWindow = 8, kFrames = 24;

class LatestWins : public testing::Test {
 protected:
  // Layers, and above them a small triangle ("mark") that few frames move.
  static pb::CreateSceneRequest request() {
    auto request = layers_request(kSide);
    auto* mark = request.mutable_spec()->add_meshes();
    mark->set_name("mark");
    mark->set_vertex_count(3);
    mark->set_triangles(pack<uint32_t>({0, 1, 2}));
    return request;
  }

  static bool is_partial(uint64_t id) { return id % 5 == 0; }

  // Whole layers in each frame; in some, one corner of the mark comes closer to them.
  static pb::Frame frame(uint64_t id) {
    auto frame = layers_frame(id, pack_points(layer_points(kSide, kLayerGap * (1 + 0.01 * id))));
    if (id > 1 && !is_partial(id)) return frame;
    auto* mark = frame.add_updates();
    mark->set_mesh(1);
    if (id == 1) {
      mark->set_positions(pack_points({{0.5, 0.5, 1}, {0.6, 0.5, 1}, {0.5, 0.6, 1}}));
    } else {
      mark->mutable_sparse()->set_indices(pack<uint32_t>({static_cast<uint32_t>(id / 5 % 3)}));
      mark->set_positions(pack_points({{0.5 + 0.01 * id, 0.5, kLayerGap}}));
    }
    return frame;
  }

  struct Run {
    std::set<uint64_t> skipped;
    std::string last_contacts;
  };

  // Sends as many frames as the window allows; receive() checks the order.
  Run run(pb::DeliveryPolicy delivery) {
    Run run;
    Stream stream(*stub_, make_scene(*stub_, request()), kWindow, "", delivery);
    for (uint64_t id = 1; id <= kWindow; ++id) stream.send(frame(id));
    for (uint64_t id = 1; id <= kFrames; ++id) {
      const Answer answer = stream.receive(id);
      EXPECT_TRUE(answer.done || answer.skipped) << (answer.error ? answer.error->message() : "ended");
      if (answer.skipped) run.skipped.insert(id);
      if (id + kWindow <= kFrames) stream.send(frame(id + kWindow));
      run.last_contacts = answer.contacts();
    }
    EXPECT_TRUE(stream.finish().ok());
    return run;
  }

  DaemonProcess daemon_;
  Probe probe_{daemon_};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

TEST_F(LatestWins, NothingIsLostAndTheNewestIsAnswered) {
  const Run latest = run(pb::DELIVERY_POLICY_LATEST_WINS);
  EXPECT_FALSE(latest.skipped.empty());
  EXPECT_FALSE(latest.skipped.contains(1));
  EXPECT_FALSE(latest.skipped.contains(kFrames));
  for (const uint64_t id : latest.skipped) EXPECT_FALSE(is_partial(id)) << id;
  EXPECT_EQ(probe_.metric("collided_skipped_frames_total"), latest.skipped.size());
  const Run lossless = run(pb::DELIVERY_POLICY_LOSSLESS);
  EXPECT_TRUE(lossless.skipped.empty());
  EXPECT_FALSE(lossless.last_contacts.empty());
  EXPECT_TRUE(latest.last_contacts == lossless.last_contacts);  // too long to print
}

// A refused frame gets its error in order, and does not make others give way.
TEST_F(LatestWins, ARefusedFrameSkipsNothing) {
  Stream stream(*stub_, make_scene(*stub_, request()), kWindow, "", pb::DELIVERY_POLICY_LATEST_WINS);
  stream.send(frame(1));
  stream.send(frame(2));
  auto bad = frame(3);
  bad.mutable_updates(0)->mutable_positions()->pop_back();
  stream.send(bad);
  EXPECT_TRUE(stream.receive(1).done);
  EXPECT_TRUE(stream.receive(2).done);
  const Answer refused = stream.receive(3);
  ASSERT_TRUE(refused.error);
  EXPECT_EQ(refused.error->code(), grpc::INVALID_ARGUMENT);
}

TEST_F(LatestWins, APolicyThatDoesNotExistIsRefused) {
  const auto status = Stream(*stub_, make_scene(*stub_, request()), 0, "", static_cast<pb::DeliveryPolicy>(9)).finish();
  expect_field(status, grpc::INVALID_ARGUMENT, "open.delivery");
}

}  // namespace
}  // namespace collided::test
