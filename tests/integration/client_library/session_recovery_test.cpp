// A session's contacts are those of an undisturbed run, whatever happens to its connection and to the daemon.
#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <functional>
#include <future>

#include "tests/integration/client_library/session_daemon.hpp"
#include "tests/integration/client_library/session_scene.hpp"
#include "tests/integration/support/peers/http2_frames.hpp"
#include "tests/integration/support/peers/tcp_proxy.hpp"

namespace collided::test {
namespace {

using client::Local;

using Frames = std::function<SessionFrame(uint64_t id)>;

/// The contacts of frames 1 to `last` of an undisturbed stream.
std::vector<std::string> undisturbed(const std::string& address, const pb::SceneSpec& spec, const Frames& frames,
                                     uint64_t last) {
  Client client = Client::connect(address);
  const SessionMeshes meshes;
  FrameStream stream = client.stream(client.create_scene(spec, meshes.inputs));
  std::vector<std::string> out{""};
  for (uint64_t id = 1; id <= last; ++id) {
    const SessionFrame frame = frames(id);
    stream.send(id, frame.updates(), frame.options);
    const FrameOutput output = stream.receive();
    output.check();
    out.push_back(digest(output));
  }
  return out;
}

/// A session whose answers are compared with those of an undisturbed stream.
struct Compared {
  Compared(const std::string& address, const pb::SceneSpec& spec, Frames of, uint64_t last,
           const std::string& reference, const SessionOptions& options)
      : frames(std::move(of)), expected(undisturbed(reference, spec, frames, last)) {
    session.emplace(Session::open(address, spec, SessionMeshes().inputs, options));
  }

  void submit(int count) {
    for (int i = 0; i < count; ++i) {
      const SessionFrame frame = frames(++sent);
      answers.push_back(session->submit(frame.updates(), frame.options));
    }
  }
  void expect_answers() {
    for (; !answers.empty(); answers.pop_front()) {
      const FrameOutput output = answers.front().get();
      EXPECT_EQ(output.frame_id, ++answered);
      partial_ways += output.done.advanced() > 0 && output.done.advanced() < 1;
      shortened += output.advance.ids.size();
      EXPECT_EQ(digest(output), expected[answered]) << "frame " << answered;
    }
  }
  void detect(int count) {
    for (int i = 0; i < count; ++i) submit(1), expect_answers();
  }
  void expect_counts(uint64_t reconnects, uint64_t recreations) const {
    EXPECT_EQ(session->reconnects(), reconnects);
    EXPECT_EQ(session->recreations(), recreations);
  }

  const Frames frames;
  const std::vector<std::string> expected;
  std::optional<Session> session;
  std::deque<std::future<FrameOutput>> answers;
  uint64_t sent = 0, answered = 0;
  int partial_ways = 0;  ///< frames that were allowed a part of theirs
  size_t shortened = 0;  ///< meshes or vertices that were, of all frames
};

SessionOptions over(Local use) { return {.stream = {.window = 3, .local = {.use = use}}}; }

struct Kind {
  pb::DetectionMode mode;
  Local use;
};

Compared compare(const MortalDaemon& daemon, pb::DetectionMode mode, Local use, uint64_t last) {
  return {daemon.address(), session_spec(mode), [mode](uint64_t id) { return session_frame(id, mode); }, last,
          daemon.address(), over(use)};
}

class SessionRecovery : public ::testing::TestWithParam<Kind> {};

TEST_P(SessionRecovery, ADaemonThatIsKilledInMidStreamLeavesNoTrace) {
  MortalDaemon daemon;
  Compared compared = compare(daemon, GetParam().mode, GetParam().use, 18);
  compared.detect(6);
  daemon.pause();
  compared.submit(3);  // in flight for certain
  daemon.kill();
  daemon.start();
  compared.expect_answers();
  compared.expect_counts(1, 1);
  compared.detect(3);
  daemon.kill();  // while nothing is in flight
  daemon.start();
  compared.submit(6);
  compared.expect_answers();
  compared.expect_counts(2, 2);
}

INSTANTIATE_TEST_SUITE_P(, SessionRecovery,
                         ::testing::Values(Kind{pb::DETECTION_MODE_DCD, Local::kOff},
                                           Kind{pb::DETECTION_MODE_DCD, Local::kOn},
                                           Kind{pb::DETECTION_MODE_CCD, Local::kOff},
                                           Kind{pb::DETECTION_MODE_CCD, Local::kOn},
                                           Kind{pb::DETECTION_MODE_DCD_AND_CCD, Local::kOff},
                                           Kind{pb::DETECTION_MODE_DCD_AND_CCD, Local::kOn}),
                         [](const auto& kind) {
                           const std::string mode = kind.param.mode == pb::DETECTION_MODE_DCD   ? "Dcd"
                                                    : kind.param.mode == pb::DETECTION_MODE_CCD ? "Ccd"
                                                                                                : "Both";
                           return mode + (kind.param.use == Local::kOff ? "Grpc" : "SharedMemory");
                         });

TEST(SessionFrames, AFirstFrameThatWasNotAnsweredIsSentAgain) {
  MortalDaemon daemon;
  for (const Local use : {Local::kOff, Local::kOn}) {
    Compared compared = compare(daemon, pb::DETECTION_MODE_CCD, use, 4);
    daemon.pause();
    compared.submit(2);
    daemon.kill();
    daemon.start();
    compared.expect_answers();
    compared.detect(2);
    compared.expect_counts(1, 1);
  }
}

TEST(SessionFrames, ADaemonThatStopsForAWhileLosesNothing) {
  MortalDaemon daemon;
  for (const Local use : {Local::kOff, Local::kOn}) {
    Compared compared = compare(daemon, pb::DETECTION_MODE_CCD, use, 6);
    compared.detect(2);
    daemon.pause();
    compared.submit(3);
    EXPECT_EQ(compared.answers.front().wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
    daemon.process().signal(SIGCONT);
    compared.submit(1);
    compared.expect_answers();
    compared.expect_counts(0, 0);
  }
}

// A local socket has no keepalive.
TEST(SessionFrames, ADaemonThatHangsIsALossOverSharedMemoryToo) {
  MortalDaemon daemon;
  constexpr auto mode = pb::DETECTION_MODE_CCD;
  SessionOptions options = over(Local::kOn);
  options.give_up = std::chrono::seconds(2);
  Compared compared(
      daemon.address(), session_spec(mode), [](uint64_t id) { return session_frame(id, mode); }, 4, daemon.address(),
      options);
  compared.detect(2);
  daemon.pause();
  compared.submit(1);
  EXPECT_EQ(compared.answers.front().wait_for(std::chrono::seconds(40)), std::future_status::ready);
  daemon.process().signal(SIGCONT);
  EXPECT_THROW(compared.answers.front().get(), client::Error);
}

TEST(SessionFrames, AFrameThatTakesLongIsNoLossWhileTheDaemonAnswers) {
  MortalDaemon daemon;
  Compared compared = compare(daemon, pb::DETECTION_MODE_CCD, Local::kOn, 4);
  compared.detect(2);
  daemon.pause();
  compared.submit(1);
  constexpr std::chrono::seconds kUntilItIsAsked(12);
  EXPECT_EQ(compared.answers.front().wait_for(kUntilItIsAsked), std::future_status::timeout);
  daemon.process().signal(SIGCONT);
  compared.expect_answers();
  compared.expect_counts(0, 0);
}

/// Falls on the ground, as far as is certified: whole, sparse, and with the ball, which turns.
SessionFrame falling_frame(uint64_t id) {
  const bool is_sparse = id % 3 == 0;
  SessionFrame frame;
  frame.cloth = pack_points(cloth_points(0, 1.2 - 0.25 * static_cast<double>(id)), true);
  frame.options.advance = true;
  if (id == 1) {
    frame.ball = pack_points({{0.3, 0.3, 3}, {0.5, 0.3, 3}, {0.3, 0.5, 3}, {0.3, 0.3, 3.2}}, true);
    frame.ground = pack_points({{-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}}, true);
  } else if (is_sparse) {
    frame.cloth = frame.cloth.substr(0, 2 * 24), frame.vertices = pack<uint32_t>({0, 1});
  } else {
    // About a line through (0.35, 0.35, 3.05), and down: what keeps it up from frame 5 on ends its turn in between.
    const double angle = 0.35 * static_cast<double>(id), c = std::cos(angle), s = std::sin(angle);
    const double y = 0.35, z = 3.05, depth = 0.62 * static_cast<double>(id);
    frame.pose = RigidMatrix{1, 0, 0, 0, 0, c, -s, y - (c * y - s * z), 0, s, c, z - (s * y + c * z) - depth};
  }
  return frame;
}

class SessionAdvance : public ::testing::TestWithParam<pb::AdvanceMode> {};

TEST_P(SessionAdvance, AfterALossFramesBeginWhereAdvancesEnded) {
  MortalDaemon daemon;
  const auto frames = [](uint64_t id) {
    SessionFrame frame = falling_frame(id);
    frame.options.advance_mode = GetParam();
    return frame;
  };
  for (const Local use : {Local::kOff, Local::kOn}) {
    pb::SceneSpec spec = session_spec(pb::DETECTION_MODE_CCD, pb::POSITION_FORMAT_F64);
    spec.set_thickness(0);
    spec.set_min_separation(0.001);
    Compared compared(daemon.address(), spec, frames, 8, daemon.address(), over(use));
    for (int round = 0; round < 2; ++round) {
      compared.detect(2);
      daemon.pause();
      compared.submit(2);
      daemon.kill();
      daemon.start();
      compared.expect_answers();
    }
    compared.expect_counts(2, 2);
    EXPECT_GT(compared.partial_ways, 0);
    EXPECT_EQ(compared.shortened > 0, GetParam() != pb::ADVANCE_MODE_ALL_OR_ONE);
  }
}

INSTANTIATE_TEST_SUITE_P(, SessionAdvance,
                         ::testing::Values(pb::ADVANCE_MODE_ALL_OR_ONE, pb::ADVANCE_MODE_PER_MESH,
                                           pb::ADVANCE_MODE_PER_VERTEX));

// What the daemon applied before the connection broke, though its answer was lost, is taken back.
TEST(SessionConnection, ABrokenConnectionIsResumedAtTheLastAnswer) {
  LocalDaemon daemon({"--address", "127.0.0.1:0"});
  constexpr auto mode = pb::DETECTION_MODE_CCD;
  const std::string last = session_frame(10, mode).cloth;
  std::atomic<bool> is_relayed = false;
  const auto look = [&](const Http2Frames::Frame& frame) {
    if (frame.type == Http2Frames::kData && frame.payload.find(last) != frame.payload.npos) is_relayed = true;
  };
  Http2Frames sent;
  TcpProxy proxy(daemon.process().tcp_address(),
                 [&](size_t connection, std::string_view bytes) { sent.take(connection, bytes, look); });
  Compared compared(
      proxy.address(), session_spec(mode), [](uint64_t id) { return session_frame(id, mode); }, 12,
      daemon.process().address(), over(Local::kOff));
  compared.detect(8);
  const double frames = daemon.probe().metric("collided_frames_total");
  pause(daemon.process());
  compared.submit(2);
  EXPECT_TRUE(eventually("the frames are with the daemon", [&] { return is_relayed.load(); }));
  proxy.unplug();
  daemon.process().signal(SIGCONT);
  EXPECT_TRUE(daemon.probe().becomes("collided_frames_total", frames + 2));
  proxy.cut();
  proxy.plug();
  compared.expect_answers();
  compared.detect(2);
  compared.expect_counts(1, 0);
}

}  // namespace
}  // namespace collided::test
