// The effect of one client on another's frames: however many scenes it has, however long its frames run.
#include "tests/integration/fairness/fair_clients.hpp"

#include <gtest/gtest.h>

namespace collided::test {
namespace {

constexpr std::chrono::seconds kPatience(50);

class FairClients : public NamedClients, public testing::Test {};

/// Concurrent loads of two clients.
struct TwoLoads {
  const FrameLoad many, one;

  void wait_until_on() const {
    eventually(
        "the loads are on", [this] { return many.is_on() && one.is_on(); }, kPatience);
  }
  uint64_t refused() const { return many.refused() + one.refused(); }
};

// Equal frames, and both clients always have some waiting: shared by scene, one would get a frame in forty. Half would
// be fair; the margin is for machines on which a client's only thread does not always get to run.
TEST_F(FairClients, FortyScenesOfOneDoNotStopTheSceneOfAnother) {
  constexpr int kScenes = 40;
  constexpr uint64_t kFrames = 40, kMost = kFrames * kScenes / 4;
  {
    const TwoLoads loads{{stubs("many", kScenes), layers_work(40, 4)}, {stubs("one", 1), layers_work(40, 4)}};
    loads.wait_until_on();
    const uint64_t of_one = loads.one.frames(), of_many = loads.many.frames();
    eventually(
        "the modest client is served", [&] { return loads.one.frames() >= of_one + kFrames; }, kPatience);
    EXPECT_LE(loads.many.frames() - of_many, kMost);
    EXPECT_EQ(loads.refused(), 0u);
  }
  aftermath_.expect_unharmed();
}

// Many short frames run while a long one does: it yields to them repeatedly.
void expect_short_between_long(const TwoLoads& loads) {
  constexpr uint64_t kLong = 4, kLeastShort = 3 * kLong;
  loads.wait_until_on();
  const uint64_t of_many = loads.many.frames(), of_one = loads.one.frames();
  eventually(
      "long frames are answered", [&] { return loads.many.frames() >= of_many + kLong; }, kPatience);
  EXPECT_GE(loads.one.frames() - of_one, kLeastShort);
  EXPECT_EQ(loads.refused(), 0u);
}

TEST_F(FairClients, LongFramesGiveWayToShortOnes) {
  {
    const TwoLoads loads{{stubs("many", 4), layers_work(200, 2)}, {stubs("one", 1), layers_work(4, 1)}};
    expect_short_between_long(loads);
  }
  aftermath_.expect_unharmed();
}

// Without tokens all clients have one name, and each connection takes turns of its own.
TEST(ClientsWithoutTokens, LongFramesGiveWayToShortOnesOfOtherConnections) {
  DaemonProcess daemon({"--threads", "2"}, "cpu");
  const auto stubs = [&](int first, int count) {
    std::vector<std::unique_ptr<Stub>> all;
    for (int i = 0; i < count; ++i)
      all.push_back(pb::CollisionService::NewStub(channel_to(daemon.address(), first + i)));
    return all;
  };
  const TwoLoads loads{{stubs(1, 4), layers_work(200, 2)}, {stubs(10, 1), layers_work(4, 1)}};
  expect_short_between_long(loads);
}

TEST_F(FairClients, AFrameThatRunsForTooLongIsRefusedAndItsStreamGoesOn) {
  constexpr uint32_t kSide = 100;
  const auto positions = pack_points(layer_points(kSide, kLayersApart));
  {
    const auto hasty = stub("hasty"), patient = stub("one");
    const std::string id = make_scene(*hasty, layers_request(kSide));
    Stream stream(*hasty, id);
    for (uint64_t frame = 1; frame <= 3; ++frame) {
      const Answer answer = stream.ask(layers_frame(frame, positions));
      ASSERT_TRUE(answer.error);
      EXPECT_EQ(answer.error->code(), grpc::RESOURCE_EXHAUSTED);
      const std::string told = "max_frame_seconds is 0.001, and frame " + std::to_string(frame) + " has run for ";
      EXPECT_EQ(answer.error->message().find(told), 0u) << answer.error->message();
    }
    EXPECT_TRUE(stream.finish().ok());
    expect_quota(detect(*hasty, id, layers_frame(4, positions)), "max_frame_seconds", "client:hasty");
    pb::Scene scene;
    EXPECT_TRUE(get_scene(*hasty, id, &scene).ok());
    EXPECT_EQ(scene.last_frame_id(), 0u);
    const std::string other = make_scene(*patient, layers_request(kSide));
    EXPECT_TRUE(detect(*patient, other, layers_frame(1, positions)).ok());
    EXPECT_TRUE(delete_scene(*hasty, id).ok() && delete_scene(*patient, other).ok());
  }
  aftermath_.expect_unharmed();
}

TEST(MaxAccuracy, IsTheMostThatScenesAndFramesGet) {
  const TokensFile tokens({{"exact", "max-accuracy = \"exact\"\n"}, {"plain"}});
  DaemonProcess daemon({"--tokens-file", tokens.path(), "--max-accuracy", "guarded"});
  const auto stub = pb::CollisionService::NewStub(channel_as("plain", daemon.address()));
  auto request = tip_request();
  const auto scene = made_scene(*stub, request);
  EXPECT_EQ(scene.spec().accuracy(), pb::ACCURACY_GUARDED);
  request.mutable_spec()->set_accuracy(pb::ACCURACY_CERTIFIED);
  const auto refused = create_scene(*stub, request);
  expect_field(refused, grpc::RESOURCE_EXHAUSTED, "spec.accuracy");
  EXPECT_EQ(refused.error_message(), "spec.accuracy is ACCURACY_CERTIFIED, above max_accuracy, ACCURACY_GUARDED");
  auto frame = first_frame(2);
  frame.set_accuracy(pb::ACCURACY_EXACT);
  expect_field(detect(*stub, scene.scene_id(), frame), grpc::RESOURCE_EXHAUSTED, "frame.accuracy");
  EXPECT_TRUE(detect(*stub, scene.scene_id(), first_frame(2)).ok());
  const auto exact = pb::CollisionService::NewStub(channel_as("exact", daemon.address()));
  EXPECT_EQ(made_scene(*exact, request).spec().accuracy(), pb::ACCURACY_CERTIFIED);
  EXPECT_EQ(made_scene(*exact, tip_request()).spec().accuracy(), pb::ACCURACY_CERTIFIED);
}

}  // namespace
}  // namespace collided::test
