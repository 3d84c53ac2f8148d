// A device that fails for good under a real daemon: streams end, nothing new is served, the process ends with 1.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

constexpr auto kCuda = pb::BACKEND_CUDA;
constexpr auto kPause = std::chrono::milliseconds(5);

bool has_gpu(Stub& stub) {
  pb::GetServerInfoResponse response;
  grpc::ClientContext context;
  EXPECT_TRUE(stub.GetServerInfo(&context, {}, &response).ok());
  return std::any_of(response.devices().begin(), response.devices().end(),
                     [](const auto& device) { return device.backend() == kCuda; });
}

TEST(FailedDevice, EndsTheStreamsAndTheDaemon) {
  const auto file = std::filesystem::temp_directory_path() / ("collided-fail-" + std::to_string(getpid()));
  setenv("COLLIDED_FAIL_DEVICE", file.c_str(), 1);
  setenv("LD_PRELOAD", setting("COLLIDED_FAIL_DEVICE_LIBRARY", COLLIDED_FAIL_DEVICE_LIBRARY).c_str(), 1);
  DaemonProcess daemon({}, "auto");
  unsetenv("LD_PRELOAD");
  const Probe probe(daemon);
  const auto stub = pb::CollisionService::NewStub(daemon.channel());
  if (!has_gpu(*stub)) GTEST_SKIP() << "no CUDA device can be used";

  auto request = tip_request();
  request.mutable_spec()->set_backend(kCuda);
  Stream busy(*stub, make_scene(*stub, request)), idle(*stub, make_scene(*stub, request));
  expect_tip_contact(busy.ask(first_frame(2)), 2);
  EXPECT_TRUE(http_get(daemon.http_address(), "/readyz").starts_with("HTTP/1.1 200"));

  std::ofstream(file) << "now";
  for (uint64_t id = 2; !busy.ask(tip_frame(id, 2)).ended; ++id) std::this_thread::sleep_for(kPause);
  EXPECT_EQ(busy.wait_end().error_code(), grpc::UNAVAILABLE);
  EXPECT_EQ(idle.wait_end().error_code(), grpc::UNAVAILABLE);
  EXPECT_EQ(daemon.wait(), 1);
  EXPECT_NE(daemon.log().find("a device no longer responds"), std::string::npos);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace collided::test
