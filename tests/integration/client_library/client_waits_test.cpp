// Client threads that wait for one stream, and a client that does not wait at all for a while.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <future>
#include <limits>
#include <optional>
#include <string_view>

#include "tests/integration/client_library/client_layers.hpp"
#include "tests/integration/client_library/client_ways.hpp"
#include "tests/integration/support/peers/http2_frames.hpp"
#include "tests/integration/support/peers/tcp_proxy.hpp"

namespace collided::test {
namespace {

using client::Error;
using std::chrono::milliseconds;

constexpr Way kToADaemon[] = {Way::kGrpc, Way::kSharedMemory};
constexpr auto kForEver = milliseconds::max();
// The keeper in the midst of frames, and after a rest, without the wait in between.
constexpr client::KeeperPace kLooks{.quiet_pauses = std::numeric_limits<int>::max()}, kStays{.quiet_pauses = 0};

struct Waiting {
  explicit Waiting(std::vector<std::string> more = {}) : daemon(over_tcp(std::move(more))) {}

  static std::vector<std::string> over_tcp(std::vector<std::string> more) {
    more.insert(more.end(), {"--address", "127.0.0.1:0"});
    return more;
  }
  /// All contacts come over the socket, even with shared memory.
  FrameStream stream(const pb::Scene& scene, Way way, uint32_t window, client::KeeperPace keeper = {}) {
    return client(way).resume(scene,
                              {.window = window, .local = {.use = use_of(way), .output_bytes = 0}, .keeper = keeper});
  }
  Client& client(Way way) { return way == Way::kInProcess ? here : there; }

  LocalDaemon daemon;
  Client there = Client::connect(daemon.process().tcp_address()), here = local();
};

void send_frame(FrameStream& stream, uint64_t id, uint32_t side = kSide) {
  const std::string positions = layers_at(id, side);
  const FrameUpdate update{.positions = bytes_of(positions)};
  stream.send(id, {&update, 1});
}

void send_frames(FrameStream& stream, uint64_t first, uint64_t last, uint32_t side = kSide) {
  for (uint64_t id = first; id <= last; ++id) send_frame(stream, id, side);
}

/// Frames that have the positions of another one have its contacts.
void expect_frame(const FrameOutput& output, uint64_t id, uint64_t contacts) {
  EXPECT_NO_THROW(output.check());
  EXPECT_EQ(output.frame_id, id);
  EXPECT_EQ(output.vertex_triangle.count, contacts);
  EXPECT_EQ(output.vertex_triangle.stencils.size(), contacts);
}

TEST(ClientWaits, OneThreadSendsWhileAnotherReceives) {
  constexpr uint64_t kFrames = 60, kKnown = 3;
  Waiting waiting;
  for (const Way way : kEveryWay) {
    FrameStream stream = waiting.stream(make_layers(waiting.client(way)), way, 4);
    std::vector<uint64_t> contacts;
    for (uint64_t id = 1; id <= kKnown; ++id) contacts.push_back(ask_whole(stream, id).vertex_triangle.count);
    auto sender = std::async(std::launch::async, [&] { send_frames(stream, kKnown + 1, kFrames); });
    for (uint64_t id = kKnown + 1; id <= kFrames; ++id)
      expect_frame(stream.receive_within(kForEver).value(), id, contacts[(id - 1) % kKnown]);
    EXPECT_NO_THROW(sender.get());
    EXPECT_NO_THROW(stream.finish());
  }
}

// One thread sends more than the window before it receives anything: it takes the answers while it waits for credits.
TEST(ClientWaits, ASenderThatWaitsForCreditsTakesTheAnswers) {
  constexpr uint64_t kFrames = 20;
  Waiting waiting;
  for (const Way way : kEveryWay) {
    FrameStream stream = waiting.stream(make_layers(waiting.client(way)), way, 4);
    send_frames(stream, 1, kFrames);
    for (uint64_t id = 1; id <= kFrames; ++id) EXPECT_EQ(stream.receive().frame_id, id);
    EXPECT_THROW(stream.receive(), Error);  // nothing is in flight
  }
}

// The daemon does not have to hold answers for a client that is computing.
TEST(ClientWaits, AnswersComeWhileNobodyWaits) {
  constexpr uint64_t kFrames = 8;
  constexpr uint32_t kLarge = 60;  // no socket holds the contacts of all frames
  double answered = 0;
  Waiting waiting;
  const Probe& probe = waiting.daemon.probe();
  for (const Way way : kToADaemon) {
    FrameStream stream = waiting.stream(make_layers(waiting.client(way), kLarge), way, kFrames);
    send_frames(stream, 1, kFrames, kLarge);
    EXPECT_TRUE(probe.becomes("collided_frames_total", answered += kFrames));
    EXPECT_TRUE(probe.becomes("collided_outgoing_bytes", 0));
    for (uint64_t id = 1; id <= kFrames; ++id) EXPECT_EQ(stream.receive().frame_id, id);
  }
}

TEST(ClientWaits, AStreamIsDestroyedWithFramesInFlight) {
  constexpr uint32_t kWindow = 4;
  Waiting waiting;
  for (const Way way : kEveryWay) {
    const pb::Scene scene = make_layers(waiting.client(way));
    for (int round = 0; round < 10; ++round) {
      FrameStream stream = waiting.stream(scene, way, kWindow);
      const uint64_t last = stream.scene().last_frame_id();
      send_frames(stream, last + 1, last + kWindow);
    }
    EXPECT_TRUE(way == Way::kInProcess || waiting.daemon.probe().streams_become(0));
    FrameStream stream = waiting.stream(scene, way, kWindow);
    EXPECT_GT(ask_whole(stream, stream.scene().last_frame_id() + 1).vertex_triangle.count, 0u);
  }
}

/// Outputs until the stream ends, which must be the end that finish() asks for.
uint64_t receive_all(FrameStream& stream) {
  uint64_t outputs = 0;
  try {
    while (stream.receive_within(kForEver)) ++outputs;
  } catch (const Error& end) {
    EXPECT_EQ(end.code(), grpc::FAILED_PRECONDITION) << end.what();
  }
  return outputs;
}

TEST(ClientWaits, AnotherThreadFinishesWhileOneReceives) {
  constexpr uint64_t kFrames = 4;
  Waiting waiting;
  for (const Way way : kEveryWay)
    for (const uint64_t frames : {uint64_t{0}, kFrames}) {
      FrameStream stream = waiting.stream(make_layers(waiting.client(way)), way, kFrames);
      auto outputs = std::async(std::launch::async, [&] { return receive_all(stream); });
      send_frames(stream, 1, frames);
      EXPECT_NO_THROW(stream.finish());
      EXPECT_EQ(outputs.get(), frames);
      EXPECT_THROW(send_frame(stream, kFrames + 1), Error);
    }
}

/// Why the stream accepts no more of them.
int send_until_refused(FrameStream& stream) {
  try {
    for (uint64_t id = 1;; ++id) send_frame(stream, id);
  } catch (const Error& end) {
    return end.code();
  }
}

TEST(ClientWaits, AnotherThreadFinishesWhileOneSends) {
  Waiting waiting;
  for (const Way way : kEveryWay)
    for (int round = 0; round < 5; ++round) {
      FrameStream stream = waiting.stream(make_layers(waiting.client(way)), way, 2);
      auto code = std::async(std::launch::async, [&] { return send_until_refused(stream); });
      EXPECT_TRUE(stream.receive_within(kForEver));
      EXPECT_NO_THROW(stream.finish());
      EXPECT_EQ(code.get(), grpc::FAILED_PRECONDITION);
    }
}

TEST(ClientWaits, AnIdleStreamIsToldThatTheDaemonStops) {
  constexpr double kGrace = 30;
  for (const Way way : kToADaemon)
    for (const client::KeeperPace pace : {kLooks, kStays}) {
      Waiting waiting({"--grace-seconds", std::to_string(kGrace)});
      std::optional<FrameStream> stream = waiting.stream(make_layers(waiting.client(way)), way, 2, pace);
      ask_whole(*stream, 1);
      EXPECT_FALSE(stream->draining_deadline());
      waiting.daemon.process().signal(SIGTERM);
      EXPECT_TRUE(eventually("the stop is known", [&] { return stream->draining_deadline().has_value(); }));
      EXPECT_LE(stream->draining_deadline().value_or(0), kGrace);
      ask_whole(*stream, 2);  // it still serves
      stream.reset();
      EXPECT_EQ(waiting.daemon.process().wait(), 0);
    }
}

// The daemon waits so long for an answer that none is late on any machine: the test looks at the answers themselves.
// gRPC's own backup polling is switched off before gRPC starts, so that each answer is the stream's doing.
TEST(ClientWaits, AnIdleClientAnswersPings) {
  Waiting waiting({"--keepalive-seconds", "1", "--keepalive-timeout-seconds", "60"});
  for (const client::KeeperPace pace : {kLooks, kStays}) {
    Http2Frames frames;
    std::atomic<int> answers = 0;
    const auto count = [&](const Http2Frames::Frame& frame) {
      if (frame.type == Http2Frames::kPing && (frame.flags & Http2Frames::kIsAnswer) != 0) ++answers;
    };
    TcpProxy proxy(waiting.daemon.process().tcp_address(),
                   [&](size_t connection, std::string_view bytes) { frames.take(connection, bytes, count); });
    Client client = Client::connect(proxy.address());
    FrameStream stream = client.stream(make_layers(client), {.local = {.use = client::Local::kOff}, .keeper = pace});
    ask_whole(stream, 1);
    const int before = answers;
    EXPECT_TRUE(eventually("pings are answered", [&] { return answers >= before + 2; }));
    EXPECT_GT(ask_whole(stream, 2).vertex_triangle.count, 0u);
  }
}

const bool is_switched_off = setenv("GRPC_CLIENT_CHANNEL_BACKUP_POLL_INTERVAL_MS", "0", 1) == 0;

}  // namespace
}  // namespace collided::test
