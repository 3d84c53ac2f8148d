// Large answers that nobody takes: their memory counts with the scenes, so that everything stays within the limits.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/integration/local/local_daemon.hpp"
#include "tests/integration/support/bystander.hpp"
#include "tests/integration/support/client_channel.hpp"
#include "tests/integration/support/peers/raw_stream.hpp"

namespace collided::test {
namespace {

constexpr double kMebibyte = 1 << 20;
constexpr int kScenes = 16, kLimit = 256, kDecode = 32, kNetwork = 64;  // MiB
constexpr uint32_t kTriangles = 250;

/// Every vertex sweeps through the boxes of all triangles, and every edge: 650,000 candidates.
pb::CreateSceneRequest crowd_request() {
  pb::CreateSceneRequest request;
  auto* spec = request.mutable_spec();
  spec->set_mode(pb::DETECTION_MODE_CCD);
  spec->set_accuracy(pb::ACCURACY_CANDIDATES);
  auto* mesh = spec->add_meshes();
  mesh->set_name("crowd");
  mesh->set_vertex_count(3 * kTriangles);
  std::vector<uint32_t> corners(3 * kTriangles);
  for (uint32_t i = 0; i < corners.size(); ++i) corners[i] = i;
  mesh->set_triangles(pack(corners));
  return request;
}

pb::Frame crowd_frame(uint64_t id) {
  Points start, end;
  for (uint32_t i = 0; i < kTriangles; ++i)
    for (const auto& [x, y, z] : Points{{0, 0, 0}, {0.5, 0, 0}, {0, 0.5, 0.5}}) {
      start.push_back({x + 1e-4 * i, y, z});
      end.push_back({x + 1e-4 * i + 1, y + 1, z + 1});
    }
  pb::Frame frame;
  frame.set_frame_id(id);
  auto* update = frame.add_updates();
  update->set_start_positions(pack_points(start));
  update->set_positions(pack_points(end));
  return frame;
}

class AnswerMemory : public testing::Test {
 protected:
  /// One after the other, so that as many as possible have an answer.
  void await_answers() const {
    eventually(
        "all frames are worked off", [&] { return answered() + refused() >= static_cast<double>(scenes_.size()); },
        kPatience);
  }
  void expect_bounded() const {
    EXPECT_GT(probe_.device_bytes() / kMebibyte, 0.5 * kLimit) << "the attack is too weak to show anything";
    EXPECT_LE((scene_bytes() + probe_.metric("collided_outgoing_bytes")) / kMebibyte, kLimit);
    EXPECT_LT((probe_.peak_resident_bytes() - before_) / kMebibyte,
              memory_limit(kLimit + kDecode + kNetwork + kSlack) / kMebibyte);
  }
  /// Whether there was room for one more scene: the answers to others may have taken all of it.
  bool add_scene() {
    pb::Scene scene;
    const auto status = create_scene(*stub_, crowd_request(), &scene);
    if (status.ok()) scenes_.push_back(scene.scene_id());
    EXPECT_TRUE(status.ok() || status.error_code() == grpc::RESOURCE_EXHAUSTED) << status.error_message();
    return status.ok();
  }
  void expect_all_given_back() {
    for (const std::string& scene : scenes_) EXPECT_TRUE(delete_scene(*stub_, scene).ok());
    stub_.reset();  // its connection is one of the descriptors
    aftermath_.expect_unharmed();
  }
  std::shared_ptr<grpc::Channel> hog(int connection) const { return channel_as("hog", daemon_.address(), connection); }
  double refused() const { return probe_.rejected("RESOURCE_EXHAUSTED"); }

  const OpenFolder folder_;
  const TokensFile tokens_{{{"hog", "max-device-mb = " + std::to_string(kLimit) + "\n"}, {"honest"}}};
  DaemonProcess daemon_{{"--tokens-file", tokens_.path(), "--max-device-mb", std::to_string(2 * kLimit),
                         "--max-message-mb", "4", "--max-decode-mb", std::to_string(kDecode), "--max-network-mb",
                         std::to_string(kNetwork), "--local-socket", folder_.file("local"),
                         "--keepalive-timeout-seconds", "60"}};
  const Probe probe_{daemon_};
  Aftermath aftermath_{probe_, [this](int number) { return channel_as("honest", daemon_.address(), number); }};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(hog(1));
  std::vector<std::string> scenes_;

 private:
  pb::Scene scene(const std::string& id) const {
    pb::Scene scene;
    EXPECT_TRUE(get_scene(*stub_, id, &scene).ok());
    return scene;
  }
  int answered() const {
    return static_cast<int>(std::count_if(scenes_.begin(), scenes_.end(),
                                          [&](const std::string& id) { return scene(id).last_frame_id() > 0; }));
  }
  /// Without room for answers.
  double scene_bytes() const {
    double bytes = 0;
    for (const std::string& id : scenes_) {
      const pb::Scene found = scene(id);
      for (const auto& part : found.memory())
        if (part.part() != "answers") bytes += static_cast<double>(part.bytes());
    }
    return bytes;
  }
  static constexpr std::chrono::seconds kPatience{60};
  static constexpr int kSlack = 128;
  const double before_ = probe_.resident_bytes();
};

TEST_F(AnswerMemory, OfStreamsThatNobodyReads) {
  std::vector<std::unique_ptr<Stream>> streams;
  for (int i = 0; i < kScenes && add_scene(); ++i) {
    streams.push_back(std::make_unique<Stream>(*stub_, scenes_.back()));
    ASSERT_TRUE(streams.back()->opened());
    streams.back()->send(crowd_frame(1));
    await_answers();
  }
  expect_bounded();
  streams.clear();
  expect_all_given_back();
}

TEST_F(AnswerMemory, OfLocalStreamsThatNobodyReads) {
  std::vector<std::unique_ptr<LocalStream>> streams;
  const LocalSizes sizes{.output = 0, .token = token_of("hog")};
  for (int i = 0; i < kScenes && add_scene(); ++i) {
    streams.push_back(std::make_unique<LocalStream>(local_socket_of(*stub_), scenes_.back(), sizes));
    if (const auto& closed = streams.back()->closed()) {  // there is no room for its shared memory
      EXPECT_EQ(closed->code(), grpc::RESOURCE_EXHAUSTED) << closed->message();
      break;
    }
    streams.back()->send_shared(crowd_frame(1));
    await_answers();
    if (refused() > 0) break;  // nor has the next answer, or scene
  }
  expect_bounded();
  streams.clear();
  expect_all_given_back();
}

/// With a long description: 8,000 meshes, and a megabyte of names.
pb::CreateSceneRequest wordy_request() {
  pb::CreateSceneRequest request;
  auto* spec = request.mutable_spec();
  spec->set_mode(pb::DETECTION_MODE_CCD);
  for (int i = 0; i < 8000; ++i) {
    auto* mesh = spec->add_meshes();
    mesh->set_name(std::to_string(i) + std::string(120, 'x'));
    mesh->set_vertex_count(3);
    mesh->set_triangles(pack<uint32_t>({0, 1, 2}));
  }
  return request;
}

TEST_F(AnswerMemory, OfCallsThatNobodyReads) {
  constexpr int kCalls = 200, kCallsOfConnection = 50;
  scenes_.push_back(make_scene(*stub_, wordy_request()));
  pb::GetSceneRequest request;
  request.set_scene_id(scenes_.back());
  const double before = probe_.peak_resident_bytes();
  std::vector<std::unique_ptr<RawStream>> calls;
  for (int i = 0; i < kCalls; ++i) {
    calls.push_back(std::make_unique<RawStream>(hog(10 + i / kCallsOfConnection), method_path("GetScene")));
    ASSERT_TRUE(calls.back()->write(request.SerializeAsString()) && calls.back()->writes_done());
  }
  // They are made one after the other, in turns, and refused once those that wait for the socket take too much.
  eventually("answers are made or refused",
             [&] { return refused() > 0 || probe_.metric("collided_calls_in_work") == 0; });
  EXPECT_LT((probe_.peak_resident_bytes() - before) / kMebibyte, memory_limit(kDecode + 128) / kMebibyte);
  calls.clear();
  expect_all_given_back();
}

// Untouched pages are charged to the daemon once it touches them.
TEST_F(AnswerMemory, OfRegionsThatAreLargerThanTheClientsShare) {
  scenes_.push_back(make_scene(*stub_, crowd_request()));
  const LocalSizes sizes{.output = size_t{kLimit + 1} << 20, .token = token_of("hog")};
  const LocalStream stream(local_socket_of(*stub_), scenes_.back(), sizes);
  ASSERT_TRUE(stream.closed());
  EXPECT_EQ(stream.closed()->code(), grpc::RESOURCE_EXHAUSTED);
  EXPECT_NE(stream.closed()->message().find("max_device_bytes_per_client"), std::string::npos);
  expect_all_given_back();
}

}  // namespace
}  // namespace collided::test
