// Admission of frames: what is recorded, and what is refused.
#include "server/frames/intake.hpp"

#include <gtest/gtest.h>

#include "server/errors.hpp"
#include "server/refusals/status.hpp"
#include "tests/server/scenes/tiny_scene.hpp"

namespace collided::server {
namespace {

std::string bytes_of(const TrianglePositions& positions) {
  return {reinterpret_cast<const char*>(positions.data()), sizeof(positions)};
}

pb::Frame first_frame() {
  pb::Frame frame;
  frame.set_frame_id(7);
  auto* floor = frame.add_updates();
  floor->set_positions(bytes_of(floor_positions()));
  auto* tip = frame.add_updates();
  tip->set_mesh(1);
  tip->set_start_positions(bytes_of(tip_positions(1)));
  tip->set_positions(bytes_of(tip_positions(-1)));
  return frame;
}

class FrameIntake : public testing::Test {
 protected:
  static Config config() {
    Config config;
    config.backend = "cpu";
    config.threads = 1;
    return config;
  }
  SceneUse make_scene(const Client& owner = client()) {
    auto added = host_.add_scene(owner, {tip_plan(), "", 0, 30});
    added.scene->worker().post([scene = added.scene] { scene->engine().build_if_complete(); });
    added.scene->worker().flush();
    return added.scene;
  }
  // "" if the frame is admitted.
  std::string refused_field(const SceneUse& scene, IncomingFrame incoming) {
    const PendingFrame frame = admit_frame(host_, *scene, std::move(incoming));
    if (!frame.refusal) return "";
    EXPECT_EQ(frame.input.slot, nullptr);
    return describe(frame.refusal).field;
  }

  CountingObserver observer_;
  SceneHost host_{config(), observer_};
};

TEST_F(FrameIntake, NotesWhichMeshesAFrameUpdatesAndHowManyBytes) {
  const auto scene = make_scene();
  IncomingFrame incoming;
  incoming.message = first_frame();
  auto* tip = incoming.message.mutable_updates(1);
  const uint32_t corner = 0;
  tip->mutable_sparse()->set_indices(std::string(reinterpret_cast<const char*>(&corner), sizeof(corner)));
  tip->mutable_start_positions()->resize(12);
  tip->mutable_positions()->resize(12);
  incoming.answer_bytes_per_contact = 16;
  const PendingFrame frame = admit_frame(host_, *scene, std::move(incoming));
  ASSERT_FALSE(frame.refusal) << describe(frame.refusal).message;
  EXPECT_EQ(frame.frame_id, 7u);
  EXPECT_EQ(frame.bytes_in, 36u + 12 + 12 + 4);
  ASSERT_EQ(frame.meshes.size(), 2u);
  EXPECT_TRUE(frame.meshes[0].mesh == 0 && frame.meshes[0].is_whole);
  EXPECT_TRUE(frame.meshes[1].mesh == 1 && !frame.meshes[1].is_whole);
  EXPECT_TRUE(frame.input.slot && frame.input.updates.empty());
  EXPECT_EQ(frame.input.bytes_beside_contact, 16u);
}

TEST_F(FrameIntake, KeepsTheMemoryOfTheFrame) {
  const auto scene = make_scene();
  auto shared = std::make_shared<int>();
  const std::weak_ptr<int> alive = shared;
  IncomingFrame incoming;
  incoming.message = first_frame();
  incoming.memory = std::move(shared);
  PendingFrame frame = admit_frame(host_, *scene, std::move(incoming));
  EXPECT_FALSE(alive.expired());
  frame = {};
  EXPECT_TRUE(alive.expired());
}

TEST_F(FrameIntake, WhatIsWrongBecomesTheRefusal) {
  const auto modest = make_scene(client("modest", {.max_accuracy = Accuracy::kCertified}));
  const auto with = [](const std::function<void(pb::Frame&)>& spoil) {
    IncomingFrame incoming;
    incoming.message = first_frame();
    spoil(incoming.message);
    return incoming;
  };
  EXPECT_EQ(refused_field(modest, with([](pb::Frame&) {})), "");
  EXPECT_EQ(refused_field(modest, with([](pb::Frame& f) { f.set_frame_id(~uint64_t{0}); })), "frame.frame_id");
  EXPECT_EQ(refused_field(modest, with([](pb::Frame& f) { f.set_accuracy(pb::ACCURACY_EXACT); })), "frame.accuracy");
  EXPECT_EQ(refused_field(modest, with([](pb::Frame& f) { f.mutable_updates(1)->mutable_positions()->resize(9); })),
            "frame.updates[1].positions");
  IncomingFrame refused = with([](pb::Frame&) {});
  refused.refusal = std::make_exception_ptr(InvalidInput("field", "field is bad"));
  EXPECT_EQ(refused_field(modest, std::move(refused)), "field");
}

TEST_F(FrameIntake, FramesAreCountedAgainstTheRateOfTheirClient) {
  const auto slow = make_scene(client("slow", {.max_frames_per_second = 1}));
  const auto admit = [&] {
    IncomingFrame incoming;
    incoming.message = first_frame();
    return admit_frame(host_, *slow, std::move(incoming)).refusal;
  };
  EXPECT_FALSE(admit());
  const auto refusal = admit();
  ASSERT_TRUE(refusal);
  EXPECT_GT(describe(refusal).retry_after_seconds, 0);
}

}  // namespace
}  // namespace collided::server
