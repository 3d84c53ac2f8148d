// A daemon that serves several devices: two of the CPU, which need no GPU, and where there is one, the GPU.
#include <gtest/gtest.h>

#include <map>

#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

pb::CreateSceneRequest request_on(const std::string& device) {
  auto request = tip_request();
  request.mutable_spec()->set_device(device);
  return request;
}

pb::GetServerInfoResponse info_of(Stub& stub) {
  grpc::ClientContext context;
  set_deadline(context);
  pb::GetServerInfoResponse response;
  const auto status = stub.GetServerInfo(&context, {}, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return response;
}

std::string metric_of(const std::string& name, const std::string& device) {
  return "collided_device_" + name + "{device=\"" + device + "\"}";
}

class Devices : public testing::Test {
 protected:
  static constexpr uint64_t kMegabytes = 8;  // of each
  static std::vector<std::string> options() {
    const std::string all = std::to_string(2 * kMegabytes);
    return {"--device",       "cpu:0,cpu:1", "--max-device-mb",         all, "--max-device-mb-per-client", all,
            "--max-scene-mb", all,           "--max-scenes-per-client", "64"};
  }

  DaemonProcess daemon_{options(), "cpu"};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
  const Probe probe_{daemon_};
};

TEST_F(Devices, AreToldWithTheirLimits) {
  const auto info = info_of(*stub_);
  ASSERT_EQ(info.devices_size(), 2);
  for (int i = 0; i < 2; ++i) {
    const pb::Device& device = info.devices(i);
    EXPECT_EQ(device.id(), "cpu:" + std::to_string(i));
    EXPECT_EQ(device.backend(), pb::BACKEND_CPU);
    EXPECT_EQ(device.max_bytes(), kMegabytes << 20);
    EXPECT_EQ(device.free_bytes(), kMegabytes << 20);
    EXPECT_EQ(device.scenes(), 0u);
  }
}

TEST_F(Devices, ScenesAreSpreadAndEachAnswersItsFrames) {
  std::map<std::string, int> scenes;
  for (int i = 0; i < 4; ++i) {
    const pb::Scene scene = made_scene(*stub_, tip_request());
    ++scenes[scene.device_id()];
    EXPECT_TRUE(scene.spec().device().empty()) << "nobody asked for it";
    Stream stream(*stub_, scene.scene_id());
    expect_tip_contact(stream.ask(first_frame(2)), 2);
    EXPECT_TRUE(stream.finish().ok());
  }
  for (const char* device : {"cpu:0", "cpu:1"}) {
    EXPECT_GT(scenes[device], 0) << device;
    EXPECT_EQ(probe_.metric(metric_of("scenes", device)), scenes[device]);
    EXPECT_GT(probe_.metric(metric_of("held_bytes", device)), 0);
    EXPECT_GT(probe_.metric(metric_of("busy_seconds_total", device)), 0);
    EXPECT_EQ(probe_.metric(metric_of("max_bytes", device)), kMegabytes << 20);
  }
  EXPECT_TRUE(eventually("those of all devices are those of the daemon", [&] {
    return probe_.device_bytes() ==
           probe_.metric(metric_of("held_bytes", "cpu:0")) + probe_.metric(metric_of("held_bytes", "cpu:1"));
  }));
}

TEST_F(Devices, AnswersAreTheSameOnEach) {
  std::vector<std::string> answers;
  for (const char* device : {"cpu:0", "cpu:1"}) {
    const pb::Scene scene = made_scene(*stub_, request_on(device));
    EXPECT_EQ(scene.device_id(), device);
    EXPECT_EQ(scene.spec().device(), device);
    Stream stream(*stub_, scene.scene_id());
    const Answer answer = stream.ask(first_frame(2));
    expect_tip_contact(answer, 2);
    answers.emplace_back();
    for (const auto& chunk : answer.chunks) answers.back() += chunk.SerializeAsString();
  }
  EXPECT_EQ(answers[0], answers[1]);
}

TEST_F(Devices, OneThatCannotBeIsRefused) {
  const auto message = [&](const pb::CreateSceneRequest& request, grpc::StatusCode code) {
    const auto status = create_scene(*stub_, request);
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    return status.error_message();
  };
  EXPECT_EQ(message(request_on("cpu:2"), grpc::FAILED_PRECONDITION),
            "spec.device is cpu:2, but this daemon serves cpu:0, cpu:1");
  EXPECT_EQ(message(request_on("cuda:0"), grpc::FAILED_PRECONDITION),
            "spec.device is cuda:0, but this daemon serves cpu:0, cpu:1");
  EXPECT_EQ(message(request_on("gpu"), grpc::INVALID_ARGUMENT), "spec.device is \"gpu\", but must be cpu:0 or cpu:1");
  auto request = request_on("cpu:1");
  request.mutable_spec()->set_backend(pb::BACKEND_CUDA);
  EXPECT_EQ(message(request, grpc::INVALID_ARGUMENT), "spec.device is cpu:1, but spec.backend is BACKEND_CUDA");
}

// A scene's declared vertices count before it has had a frame.
TEST_F(Devices, AFullDeviceIsPassedOverAndFullOnesRefuse) {
  auto request = request_on("cpu:0");
  request.mutable_spec()->mutable_meshes(0)->set_vertex_count(20'000);
  std::map<std::string, int> scenes;
  ++scenes[made_scene(*stub_, request).device_id()];
  request.mutable_spec()->clear_device();
  EXPECT_EQ(made_scene(*stub_, request).device_id(), "cpu:1");
  grpc::Status status;
  for (int i = 0; i < 60 && status.ok(); ++i) status = create_scene(*stub_, request);
  expect_quota(status, "no device has room", "daemon");
  EXPECT_NE(status.error_message().find(" has most, "), std::string::npos) << status.error_message();
  EXPECT_NEAR(probe_.metric(metric_of("scenes", "cpu:0")), probe_.metric(metric_of("scenes", "cpu:1")), 1);
}

TEST_F(Devices, ADeletedScenesRoomIsFree) {
  const pb::Scene scene = made_scene(*stub_, request_on("cpu:1"));
  EXPECT_LT(info_of(*stub_).devices(1).free_bytes(), kMegabytes << 20);
  EXPECT_TRUE(delete_scene(*stub_, scene.scene_id()).ok());
  EXPECT_TRUE(probe_.becomes(metric_of("scenes", "cpu:1"), 0));
  EXPECT_TRUE(probe_.becomes(metric_of("free_bytes", "cpu:1"), kMegabytes << 20));
}

TEST_F(Devices, ARepeatedRequestFindsItsSceneWhereItIs) {
  auto request = tip_request();
  request.set_request_id("once");
  const pb::Scene scene = made_scene(*stub_, request), again = made_scene(*stub_, request);
  EXPECT_EQ(again.scene_id(), scene.scene_id());
  EXPECT_EQ(again.device_id(), scene.device_id());
  EXPECT_EQ(probe_.metric(metric_of("scenes", "cpu:0")) + probe_.metric(metric_of("scenes", "cpu:1")), 1);
}

TEST_F(Devices, DrainTogether) {
  for (const char* device : {"cpu:0", "cpu:1"}) make_scene(*stub_, request_on(device));
  EXPECT_EQ(daemon_.stop(), 0);
}

TEST(Device, OfThisMachineIsTheDefault) {
  DaemonProcess daemon;
  const auto stub = pb::CollisionService::NewStub(daemon.channel());
  const std::string first = test_backend() == "cuda" ? "cuda:0" : "cpu:0";
  EXPECT_EQ(info_of(*stub).devices(0).id(), first);
  EXPECT_TRUE(made_scene(*stub, tip_request()).device_id().starts_with(test_backend()));
  const pb::Scene scene = made_scene(*stub, request_on(first));
  EXPECT_EQ(scene.device_id(), first);
  Stream stream(*stub, scene.scene_id());
  expect_tip_contact(stream.ask(first_frame(2)), 2);
  EXPECT_EQ(create_scene(*stub, request_on("cuda:99")).error_code(), grpc::FAILED_PRECONDITION);
}

}  // namespace
}  // namespace collided::test
