// Scenes of two triangles hold little, so that a daemon has room for very many.
#include <gtest/gtest.h>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

constexpr uint64_t kMaxBytes = 256 << 10;

uint64_t bytes_of(const pb::Scene& scene) {
  uint64_t bytes = 0;
  for (const auto& part : scene.memory()) bytes += part.bytes();
  return bytes;
}

pb::CreateSceneRequest request_of(pb::DetectionMode mode, pb::Accuracy accuracy) {
  auto request = tip_request();
  auto* spec = request.mutable_spec();
  spec->set_mode(mode);
  spec->set_accuracy(accuracy);
  spec->set_thickness(0.01);
  return request;
}

pb::Frame frame_of(pb::DetectionMode mode) {
  pb::Frame frame = first_frame(mode == pb::DETECTION_MODE_CCD ? 2 : 1);
  if (mode == pb::DETECTION_MODE_DCD) frame.mutable_updates(0)->clear_start_positions();
  return frame;
}

TEST(SmallScenes, HoldLittleInEachModeAndAtEachLevel) {
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  for (const auto mode : {pb::DETECTION_MODE_DCD, pb::DETECTION_MODE_CCD})
    for (const auto accuracy : {pb::ACCURACY_CANDIDATES, pb::ACCURACY_FAST, pb::ACCURACY_GUARDED,
                                pb::ACCURACY_CERTIFIED, pb::ACCURACY_EXACT}) {
      SCOPED_TRACE(pb::DetectionMode_Name(mode) + " at " + pb::Accuracy_Name(accuracy));
      const auto id = make_scene(*stub, request_of(mode, accuracy));
      pb::DetectFrameResponse answer;
      const auto status = detect(*stub, id, frame_of(mode), &answer);
      ASSERT_TRUE(status.ok()) << status.error_message();
      EXPECT_EQ(answer.done().any_contact(), accuracy != pb::ACCURACY_CANDIDATES);
      pb::Scene scene;
      ASSERT_TRUE(get_scene(*stub, id, &scene).ok());
      EXPECT_LE(bytes_of(scene), kMaxBytes) << scene.ShortDebugString();
      EXPECT_EQ(answer.done().metrics().device_bytes(), bytes_of(scene));
      EXPECT_GT(bytes_of(scene), 0u);
    }
}

TEST(SmallScenes, AThousandOfThemAnswer) {
  constexpr int kScenes = 1000;
  DaemonProcess daemon({"--max-scenes", "1000", "--max-scenes-per-client", "1000", "--max-device-mb", "256",
                        "--max-device-mb-per-client", "256", "--threads", "1"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  std::vector<std::string> ids;
  for (int i = 0; i < kScenes; ++i) ids.push_back(make_scene(*stub, tip_request()));
  for (const auto& id : ids) {
    pb::DetectFrameResponse answer;
    const auto status = detect(*stub, id, first_frame(2), &answer);
    ASSERT_TRUE(status.ok()) << status.error_message();
    expect_tip_contact({answer.contacts().begin(), answer.contacts().end()}, answer.done(), 2);
    EXPECT_LE(answer.done().metrics().device_bytes(), kMaxBytes);
  }
}

}  // namespace
}  // namespace collided::test
