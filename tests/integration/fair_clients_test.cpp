// What one client does to the frames of another: however many scenes it has, however long its frames run.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/integration/client_channel.hpp"
#include "tests/integration/layers.hpp"
#include "tests/integration/probe.hpp"
#include "tests/integration/tip_scene.hpp"

namespace collided::test {
namespace {

constexpr std::chrono::seconds kPatience(50);

class FairClients : public testing::Test {
 protected:
  std::unique_ptr<Stub> stub(const std::string& client, int number = 0) const {
    return pb::CollisionService::NewStub(channel_as(client, daemon_.address(), number));
  }

  const TokensFile tokens_{{{"many", "max-scenes = 40\n"}, {"one"}, {"hasty", "max-frame-seconds = 0.001\n"}}};
  DaemonProcess daemon_{{"--tokens-file", tokens_.path()}, "cpu"};
};

/// Streams of equal frames that have always `window` in flight, each with a thread of its own, until they are told to
/// end.
class Load {
 public:
  Load(std::vector<std::unique_ptr<Stub>> stubs, uint32_t side, uint32_t window)
      : positions_(pack_points(layer_points(side, kLayersApart))), stubs_(std::move(stubs)) {
    for (const auto& stub : stubs_)
      threads_.emplace_back([this, &stub = *stub, side, window] { run(stub, side, window); });
    eventually(
        "the load is on", [&] { return running_ == static_cast<int>(stubs_.size()); }, kPatience);
  }
  ~Load() { is_over_ = true; }

  uint64_t frames() const { return frames_; }

 private:
  void run(Stub& stub, uint32_t side, uint32_t window) {
    const std::string scene = make_scene(stub, layers_request(side));
    Stream stream(stub, scene, window);
    ASSERT_TRUE(stream.opened());
    for (uint64_t id = 1; id <= window; ++id) stream.send(layers_frame(id, positions_));
    for (uint64_t id = 1; !is_over_; ++id) {
      ASSERT_TRUE(stream.receive(id).done) << id;
      if (id == 1) ++running_;
      ++frames_;
      stream.send(layers_frame(id + window, positions_));
    }
  }

  const std::string positions_;
  const std::vector<std::unique_ptr<Stub>> stubs_;
  std::atomic<bool> is_over_ = false;
  std::atomic<int> running_ = 0;
  std::atomic<uint64_t> frames_ = 0;
  std::vector<std::jthread> threads_;
};

// Equal frames, and both clients have some waiting at any time: by scenes, one would have a frame in forty. Half would
// be just; the margin is for machines where the one thread of a client does not always get to run.
TEST_F(FairClients, FortyScenesOfOneDoNotStopTheSceneOfAnother) {
  constexpr int kScenes = 40;
  constexpr uint64_t kFrames = 40, kMost = kFrames * kScenes / 4;
  constexpr uint32_t kSide = 40, kWindow = 4;
  std::vector<std::unique_ptr<Stub>> many, one;
  for (int i = 0; i < kScenes; ++i) many.push_back(stub("many", i));
  one.push_back(stub("one"));
  const Load greedy(std::move(many), kSide, kWindow), modest(std::move(one), kSide, kWindow);
  const uint64_t of_modest = modest.frames(), of_greedy = greedy.frames();
  eventually(
      "the modest client is served", [&] { return modest.frames() >= of_modest + kFrames; }, kPatience);
  EXPECT_LE(greedy.frames() - of_greedy, kMost);
}

// While one of the long frames runs, many short ones do: it gives way to them again and again.
TEST_F(FairClients, LongFramesGiveWayToShortOnes) {
  constexpr uint64_t kLong = 4, kLeastShort = 3 * kLong;
  std::vector<std::unique_ptr<Stub>> many, one;
  for (int i = 0; i < 4; ++i) many.push_back(stub("many", i));
  one.push_back(stub("one"));
  const Load slow(std::move(many), 200, 2), quick(std::move(one), 4, 1);
  const uint64_t of_slow = slow.frames(), of_quick = quick.frames();
  eventually(
      "long frames are answered", [&] { return slow.frames() >= of_slow + kLong; }, kPatience);
  EXPECT_GE(quick.frames() - of_quick, kLeastShort);
}

TEST_F(FairClients, AFrameThatRunsForTooLongIsRefusedAndItsStreamGoesOn) {
  constexpr uint32_t kSide = 100;
  const auto positions = pack_points(layer_points(kSide, kLayersApart));
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
  EXPECT_TRUE(detect(*patient, make_scene(*patient, layers_request(kSide)), layers_frame(1, positions)).ok());
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
