// Clients of the local socket that die, stop, flood or hang up: the daemon releases everything that it held for them.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <thread>

#include "tests/integration/local/local_daemon.hpp"
#include "tests/integration/support/peers/child_client.hpp"

namespace collided::test {
namespace {

constexpr double kLease = 1;
constexpr uint32_t kSmall = 10;
constexpr uint32_t kLarge = 80;  // some MiB of contacts per frame
constexpr size_t kRoomForAll = size_t{256} << 20;

class LocalPeers : public testing::Test {
 protected:
  explicit LocalPeers(const std::vector<std::string>& more = {"--keepalive-timeout-seconds", "1"}) : daemon_(more) {}

  // The first client grows the daemon's memory to what any of them needs.
  void SetUp() override {
    daemon_.expect_good_streams();
    const auto client = start(kLarge, kRoomForAll);
    client->signal(SIGKILL);
    EXPECT_TRUE(daemon_.probe().streams_become(0));
    EXPECT_TRUE(daemon_.probe().scenes_become(0));
    before_.emplace(daemon_.probe());
  }
  void expect_all_released() {
    before_->expect_back();
    daemon_.expect_good_streams();
  }
  /// A child that streams, with frames in flight.
  std::unique_ptr<ChildClient> start(uint32_t side, size_t output_bytes) {
    const std::string scene = daemon_.make_scene(layers_request(side, kLease));
    auto client = std::make_unique<ChildClient>(
        std::vector<std::string>{setting("COLLIDED_LOCAL_CLIENT", COLLIDED_LOCAL_CLIENT), daemon_.path(), scene,
                                 std::to_string(side), std::to_string(output_bytes)});
    EXPECT_TRUE(client->is_answered());
    return client;
  }

  LocalDaemon daemon_;
  std::optional<Baseline> before_;
};

class ImpatientWithIdlers : public LocalPeers {
 protected:
  ImpatientWithIdlers() : LocalPeers({"--max-idle-seconds", "1"}) {}
};

TEST_F(LocalPeers, KilledInTheMiddleOfFrames) {
  for (const uint32_t side : {kSmall, kLarge, kSmall, kLarge})
    for (const size_t output : {kRoomForAll, size_t{0}}) {
      const auto client = start(side, output);
      EXPECT_EQ(daemon_.probe().streams(), 1);
      client->signal(SIGKILL);
      EXPECT_TRUE(daemon_.probe().streams_become(0));
    }
  expect_all_released();
}

// Its answers come in packets, which it no longer takes.
TEST_F(LocalPeers, StoppedInTheMiddleOfAnswers) {
  const auto client = start(kLarge, 0);
  client->signal(SIGSTOP);
  double most_outgoing = 0;
  eventually("its stream ends", [&] {
    most_outgoing = std::max(most_outgoing, daemon_.probe().metric("collided_outgoing_bytes"));
    return daemon_.probe().streams() == 0;
  });
  EXPECT_GT(most_outgoing, 0);
  expect_all_released();
  eventually("the log tells why",
             [&] { return daemon_.process().log().find("took none of its answers for 1 s") != std::string::npos; });
}

// Its answers lie in shared memory: nothing waits for it, so that it only shows as idle.
TEST_F(ImpatientWithIdlers, StoppedWithAnswersInSharedMemory) {
  const auto client = start(kLarge, kRoomForAll);
  client->signal(SIGSTOP);
  expect_all_released();
  eventually("the log tells why",
             [&] { return daemon_.process().log().find("max_idle_seconds is 1") != std::string::npos; });
}

// What it sends past its credits stays in its own socket.
TEST_F(LocalPeers, FloodsPastItsCredits) {
  constexpr uint32_t kSide = 60, kWindow = 2;
  constexpr uint64_t kFrames = 3000;
  const double before = daemon_.probe().metric("process_resident_memory_bytes");
  {
    const auto positions = pack_points(layer_points(kSide, kLayersApart));
    const size_t input = (positions.size() + 4095) / 4096 * 4096;
    LocalStream stream(daemon_.path(), daemon_.make_scene(layers_request(kSide, kLease)),
                       {.input = input, .output = 0, .window = kWindow});
    ASSERT_TRUE(stream.opened());
    const auto all_share = shared_frame(layers_frame(1, positions), stream.memory());
    std::jthread flood([&] {
      auto frame = all_share;
      for (uint64_t id = 1; id <= kFrames && stream.raw().send(frame); ++id) frame.set_frame_id(id + 1);
    });
    for (uint64_t id = 1; id <= 100; ++id) {
      const Answer answer = stream.receive(id);
      ASSERT_TRUE(answer.done) << id;
      if (id % 10) continue;
      EXPECT_LE(daemon_.probe().metric("collided_queued_frames"), kWindow);
      EXPECT_LT(daemon_.probe().metric("process_resident_memory_bytes") - before, memory_limit(64));
    }
    shutdown(stream.raw().socket(), SHUT_RDWR);
  }
  expect_all_released();
}

TEST_F(LocalPeers, HangUpAtEveryStep) {
  const std::string scene = daemon_.make_scene(layers_request(kSmall, kLease));
  const auto positions = pack_points(layer_points(kSmall));
  for (int round = 0; round < 100; ++round) {
    if (round % 4 < 2) {
      const RawLocal raw(daemon_.path());
      if (round % 4 == 1) raw.send("\xff");
      continue;
    }
    LocalStream stream(daemon_.path(), scene);  // refused if the previous one is not gone yet
    if (round % 4 == 3) stream.send_shared(layers_frame(round + 1, positions));
  }
  expect_all_released();
}

// Each message is refused or ends its stream, with its documented error.
TEST_F(LocalPeers, SendGarbage) {
  const auto end_of = [&](const std::string& packet) {
    LocalStream stream(daemon_.path(), daemon_.make_scene(layers_request(kSmall, kLease)));
    EXPECT_TRUE(stream.opened());
    stream.raw().send(packet);
    return stream.raw().closed().code();
  };
  EXPECT_EQ(end_of("\xff\xff garbage"), grpc::INVALID_ARGUMENT);
  EXPECT_EQ(end_of(std::string((64 << 10) + 1, 'x')), grpc::RESOURCE_EXHAUSTED);
  EXPECT_EQ(end_of(open_request("another", 0, 0).SerializeAsString()), grpc::FAILED_PRECONDITION);
  expect_all_released();
}

TEST_F(LocalPeers, ManyAtOnceAreAllLetGo) {
  constexpr int kClients = 12;
  std::vector<std::unique_ptr<ChildClient>> clients;
  for (int i = 0; i < kClients; ++i) clients.push_back(start(kSmall, i % 2 ? kRoomForAll : 0));
  EXPECT_EQ(daemon_.probe().streams(), kClients);
  for (int i = 0; i < kClients; ++i) clients[i]->signal(i % 3 ? SIGKILL : SIGTERM);
  expect_all_released();
}

}  // namespace
}  // namespace collided::test
