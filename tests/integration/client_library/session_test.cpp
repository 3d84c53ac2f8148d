// Sessions that are refused something, give up, idle, or end.
#include <gtest/gtest.h>

#include <future>

#include "tests/integration/client_library/session_calls.hpp"
#include "tests/integration/client_library/session_daemon.hpp"

namespace collided::test {
namespace {

using client::Error;
using client::Local;
using std::chrono::milliseconds;

constexpr Local kWays[] = {Local::kOff, Local::kOn};

Session open_session(const std::string& address, const SessionOptions& options = {},
                     pb::SceneSpec spec = session_spec(kMode)) {
  return Session::open(address, spec, SessionMeshes().inputs, options);
}

std::future<FrameOutput> submit(Session& session, uint64_t id) {
  const SessionFrame frame = session_frame(id, kMode);
  return session.submit(frame.updates(), frame.options);
}

TEST(SessionLimits, ARefusedFrameFailsAloneAndTheSessionGoesOn) {
  MortalDaemon daemon;
  for (const Local use : kWays) {
    Session session = open_session(daemon.address(), {.stream = {.window = 3, .local = {.use = use}}});
    detect(session, 1);
    const std::string few = pack_points({{0, 0, 0}});
    const FrameUpdate update{.mesh = kCloth, .positions = bytes_of(few)},
        nowhere{.mesh = 7, .positions = bytes_of(few)};
    auto refused = session.submit({&update, 1}), lost = session.submit({&nowhere, 1}), good = submit(session, 2);
    const Error error = error_of([&] { refused.get(); });
    EXPECT_EQ(error.code(), grpc::INVALID_ARGUMENT) << error.what();
    EXPECT_EQ(error.field(), "frame.updates[0].positions");
    EXPECT_EQ(error_of([&] { lost.get(); }).field(), "frame.updates[0].mesh");
    EXPECT_EQ(good.get().frame_id, 4u);
    EXPECT_EQ(session.reconnects(), 0u);
  }
}

TEST(SessionLimits, WhatCannotBeRestoredIsRefusedBeforeItIsSent) {
  MortalDaemon daemon;
  Session session = open_session(daemon.address());
  const auto field_of = [](Session& of, const FrameOptions& options) {
    const Error error = error_of([&] { of.submit({}, options); });
    EXPECT_EQ(error.code(), grpc::INVALID_ARGUMENT) << error.what();
    return error.field();
  };
  EXPECT_EQ(field_of(session, {.edit = pb::SceneEdit()}), "options.edit");
  EXPECT_EQ(field_of(session, {.from_last_fraction = 0.5}), "options.from_last_fraction");
  pb::SceneSpec encoded = session_spec(kMode, pb::POSITION_FORMAT_Q16);
  for (int k = 0; k < 3; ++k)
    encoded.mutable_quantization_box()->add_lower(-10), encoded.mutable_quantization_box()->add_upper(10);
  Session coarse = open_session(daemon.address(), {}, encoded);
  EXPECT_EQ(field_of(coarse, {.advance = true}), "options.advance");
  EXPECT_EQ(detect(session, 1).frame_id, 1u);
}

TEST(SessionLimits, BadOptionsAreRefused) {
  const auto field_of = [](const SessionOptions& options) {
    const Error error = error_of([&] { open_session("unix:/nowhere", options); });
    EXPECT_EQ(error.code(), grpc::INVALID_ARGUMENT) << error.what();
    return error.field();
  };
  EXPECT_EQ(field_of({.give_up = milliseconds(-1)}), "options.give_up");
  EXPECT_EQ(field_of({.first_pause = milliseconds(-1)}), "options.first_pause");
  EXPECT_EQ(field_of({.first_pause = milliseconds(9), .longest_pause = milliseconds(8)}), "options.longest_pause");
  EXPECT_EQ(field_of({.stream = {.delivery = pb::DELIVERY_POLICY_LATEST_WINS}}), "options.stream.delivery");
  EXPECT_EQ(field_of({.stream = {.resume_token = "x"}}), "options.stream.resume_token");
  EXPECT_EQ(field_of({.stream = {.local = {.cuda_ipc_handle = "x"}}}), "options.stream.local.cuda_ipc_handle");
  EXPECT_EQ(field_of({.stream = {.local = {.output_cuda_ipc_handle = "x"}}}),
            "options.stream.local.output_cuda_ipc_handle");
  pb::SceneSpec spec = session_spec(kMode);
  spec.add_meshes();
  EXPECT_EQ(error_of([&] { open_session("unix:/nowhere", {}, spec); }).field(), "spec.meshes");
  const Error nobody = error_of([&] { open_session("unix:/nowhere", {.connect = {.patience = milliseconds(1)}}); });
  EXPECT_EQ(nobody.code(), grpc::UNAVAILABLE) << nobody.what();
}

TEST(SessionLimits, ASessionThatGivesUpFailsAllFramesAndGoesOnWithTheNext) {
  MortalDaemon daemon;
  for (const Local use : kWays) {
    Session session = open_session(daemon.address(), {.connect = {.patience = milliseconds(1000)},
                                                      .stream = {.window = 3, .local = {.use = use}},
                                                      .max_attempts = 1,
                                                      .first_pause = milliseconds(0)});
    detect(session, 1);
    daemon.pause();
    std::future<FrameOutput> lost[] = {submit(session, 4), submit(session, 4), submit(session, 4)};
    daemon.kill();
    for (auto& frame : lost) {
      const Error error = error_of([&] { frame.get(); });
      EXPECT_EQ(error.code(), grpc::UNAVAILABLE) << error.what();
      EXPECT_NE(error.message().find("gave up (attempts to reconnect: 1)"), std::string::npos) << error.what();
    }
    daemon.start();
    EXPECT_EQ(detect(session, 2).frame_id, 5u);  // of the ball alone: the cloth is where frame 1 left it
    EXPECT_EQ(session.recreations(), 1u);
  }
}

TEST(SessionLimits, AStreamThatIdledOutIsResumedAndASceneWhoseLeaseEndedMadeAnew) {
  LocalDaemon daemon({"--max-idle-seconds", "0.3"});
  for (const Local use : kWays) {
    Session session = open_session(daemon.process().address(), {.stream = {.local = {.use = use}}, .lease_seconds = 1});
    detect(session, 1);
    EXPECT_TRUE(daemon.probe().streams_become(0));
    detect(session, 2);
    EXPECT_GE(session.reconnects(), 1u);
    EXPECT_TRUE(daemon.probe().scenes_become(0));
    EXPECT_EQ(detect(session, 4).frame_id, 3u);
    EXPECT_GE(session.reconnects(), 2u);
    EXPECT_GE(session.recreations(), 1u);
    session.close();
  }
}

TEST(SessionLimits, AClosedSessionLeavesNoSceneAndTakesNoFrame) {
  LocalDaemon daemon;
  Session session = open_session(daemon.process().address());
  detect(session, 1);
  session.close();
  EXPECT_TRUE(daemon.probe().scenes_become(0));
  EXPECT_NO_THROW(session.close());
  EXPECT_EQ(error_of([&] { detect(session, 2); }).code(), grpc::FAILED_PRECONDITION);
}

TEST(SessionLimits, ASessionThatIsDestroyedWithdrawsItsFrames) {
  MortalDaemon daemon;
  for (const Local use : kWays)
    for (const bool is_dead : {false, true}) {
      std::vector<std::future<FrameOutput>> lost;
      {
        Session session = open_session(daemon.address(), {.connect = {.patience = milliseconds(1000)},
                                                          .stream = {.window = 2, .local = {.use = use}}});
        detect(session, 1);
        daemon.pause();
        for (const uint64_t id : {4, 9}) lost.push_back(submit(session, id));
        if (is_dead) daemon.kill();
      }
      for (auto& frame : lost) EXPECT_EQ(error_of([&] { frame.get(); }).code(), grpc::CANCELLED);
      is_dead ? daemon.start() : daemon.process().signal(SIGCONT);
    }
}

TEST(SessionLimits, ThreadsThatSubmitAtOnceAllHaveTheirAnswers) {
  MortalDaemon daemon;
  Session session = open_session(daemon.address(), {.stream = {.window = 2}});
  detect(session, 1);
  const auto many = [&] {
    for (int i = 0; i < 20; ++i) detect(session, 4);
  };
  auto one = std::async(std::launch::async, many), other = std::async(std::launch::async, many);
  daemon.kill();
  daemon.start();
  EXPECT_NO_THROW(one.get());
  EXPECT_NO_THROW(other.get());
  EXPECT_EQ(detect(session, 2).frame_id, 42u);
  EXPECT_EQ(session.recreations(), 1u);
}

}  // namespace
}  // namespace collided::test
