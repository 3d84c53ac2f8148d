// Stopping the daemon, and which sockets it replaces.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <thread>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

class Lifecycle : public testing::Test {
 protected:
  DaemonProcess daemon_;
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

TEST_F(Lifecycle, TerminationIsClean) {
  make_scene(*stub_, tip_request());
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(daemon_.stop(), 0);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(4));  // an idle client costs no grace
}

TEST_F(Lifecycle, AnOpenStreamIsToldOfTheStopAndMayFinish) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  ASSERT_TRUE(stream.ask(first_frame(2)).done);
  daemon_.signal(SIGTERM);
  pb::StreamFramesResponse response;
  ASSERT_TRUE(stream.read(&response));
  EXPECT_EQ(response.draining().deadline_seconds(), 5);
  EXPECT_EQ(create_scene(*stub_, tip_request()).error_code(), grpc::UNAVAILABLE);
  expect_tip_contact(stream.ask(tip_frame(2, 3)), 3);
  EXPECT_TRUE(stream.finish().ok());
  EXPECT_EQ(daemon_.wait(), 0);
}

TEST_F(Lifecycle, AStreamThatHasNotOpenedEndsWithTheStop) {
  grpc::ClientContext context;
  set_deadline(context);
  auto call = stub_->StreamFrames(&context);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  daemon_.signal(SIGTERM);
  pb::StreamFramesResponse response;
  EXPECT_FALSE(call->Read(&response));
  EXPECT_EQ(call->Finish().error_code(), grpc::UNAVAILABLE);
  EXPECT_EQ(daemon_.wait(), 0);
}

TEST(Daemons, AStreamThatStaysIsEndedAfterTheGrace) {
  DaemonProcess daemon({"--grace-seconds", "0.2"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  Stream stream(*stub, make_scene(*stub, tip_request()));
  daemon.signal(SIGINT);
  EXPECT_EQ(stream.wait_end().error_code(), grpc::UNAVAILABLE);
  EXPECT_EQ(daemon.wait(), 0);
}

TEST(Daemons, ASecondDaemonDoesNotTakeASocketOver) {
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto id = make_scene(*stub, tip_request());
  const auto command = "timeout 20 " + setting("COLLIDED_DAEMON", COLLIDED_DAEMON) + " --backend cpu --address ";
  FILE* second = popen((command + daemon.address() + " 2>&1").c_str(), "r");
  ASSERT_NE(second, nullptr);
  std::string text;
  for (std::array<char, 256> line; std::fgets(line.data(), line.size(), second);) text += line.data();
  EXPECT_EQ(WEXITSTATUS(pclose(second)), 1);
  EXPECT_NE(text.find("another daemon serves there"), std::string::npos) << text;
  auto again = pb::CollisionService::NewStub(daemon.channel());
  EXPECT_TRUE(Stream(*again, id).opened());
}

TEST(Daemons, ASocketThatADeadDaemonLeftIsTakenOver) {
  DaemonProcess daemon;
  daemon.signal(SIGKILL);
  daemon.wait();
  DaemonProcess next({"--address", daemon.address()});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  make_scene(*stub, tip_request());
}

}  // namespace
}  // namespace collided::test
