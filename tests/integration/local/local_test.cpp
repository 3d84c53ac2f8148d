// The local socket of a real daemon: the same frames as over gRPC, who may use it, how it stops.
#include <grp.h>
#include <gtest/gtest.h>

#include "tests/integration/local/local_daemon.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kSide = 40;
constexpr size_t kLayersInput = 1 << 20;

/// All arrays of a frame's contacts, however they were cut into chunks.
std::vector<std::string> arrays_of(const Answer& answer) {
  std::vector<std::string> arrays(6);
  for (const auto& chunk : answer.chunks) {
    arrays[0] += chunk.elements();
    arrays[1] += chunk.stencils();
    arrays[2] += chunk.toi();
    arrays[3] += chunk.distance();
    arrays[4] += chunk.flags();
    arrays[5] += std::string(chunk.count(), static_cast<char>(chunk.kind()));
  }
  return arrays;
}

pb::Frame layers_frame_of(uint64_t id) {
  return layers_frame(id, pack_points(layer_points(kSide, kLayerGap * static_cast<double>(1 + id % 3))));
}

TEST(LocalSocket, IsOffUnlessAskedFor) {
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  EXPECT_EQ(local_socket_of(*stub), "");
  int sockets = 0;
  for (const auto& file :
       std::filesystem::directory_iterator(std::filesystem::path(daemon.address().substr(5)).parent_path()))
    sockets += file.is_socket();
  EXPECT_EQ(sockets, 1) << "more than that of gRPC";
}

TEST(LocalSocket, IsNamedToClientsAndGoesWithTheDaemon) {
  LocalDaemon daemon;
  EXPECT_EQ(local_socket_of(daemon.stub()), daemon.path());
  EXPECT_TRUE(std::filesystem::is_socket(daemon.path()));
  EXPECT_EQ(std::filesystem::status(daemon.path()).permissions(), std::filesystem::perms(0600));
  EXPECT_EQ(daemon.process().stop(), 0);
  EXPECT_FALSE(std::filesystem::exists(daemon.path()));
}

// Room for all contacts, for some, and for none: the rest comes in packets, and nothing is lost.
TEST(LocalSocket, FramesAreThoseOfGrpc) {
  LocalDaemon daemon;
  for (const size_t output : {16 << 20, 64 << 10, 0}) {
    LocalStream local(daemon.path(), daemon.make_scene(layers_request(kSide)),
                      {.input = kLayersInput, .output = output, .window = 2});
    Stream remote(daemon.stub(), daemon.make_scene(layers_request(kSide)));
    ASSERT_TRUE(local.opened() && remote.opened());
    for (uint64_t id = 1; id <= 6; ++id) {
      const auto frame = layers_frame_of(id);
      const Answer near = local.ask_shared(frame), far = remote.ask(frame);
      ASSERT_TRUE(near.done && far.done) << id;
      EXPECT_GT(near.done->contact_count(), 1000u);
      EXPECT_EQ(near.done->contact_count(), far.done->contact_count());
      EXPECT_TRUE(arrays_of(near) == arrays_of(far)) << "frame " << id << ", output region of " << output;
    }
    EXPECT_EQ(local.shared_chunks() > 0, output > 0);
    EXPECT_EQ(local.packet_chunks() > 0, output < 16 << 20);
    local.raw().half_close();
    EXPECT_EQ(local.raw().closed().code(), 0);
  }
}

TEST(LocalSocket, TimesOfImpactAreThoseOfGrpc) {
  LocalDaemon daemon;
  for (const bool wide : {false, true}) {
    LocalStream local(daemon.path(), daemon.make_scene(tip_request(wide)));
    Stream remote(daemon.stub(), daemon.make_scene(tip_request(wide)));
    for (uint64_t id = 1; id <= 10; ++id) {
      const double depth = 1 + 0.25 * static_cast<double>(id);
      const auto frame = id == 1 ? first_frame(depth, wide) : tip_frame(id, depth, wide);
      const Answer near = local.ask_shared(frame), far = remote.ask(frame);
      expect_tip_contact(near, depth);
      EXPECT_EQ(arrays_of(near), arrays_of(far));
    }
  }
}

/// The daemon's message to a connection of another user, from its packet; empty if there was none.
std::string answer_to(uid_t uid, const std::string& path, const std::string& packet) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return "";
  const pid_t child = fork();
  if (child == 0) {
    if (setgroups(0, nullptr) != 0 || setgid(uid) != 0 || setuid(uid) != 0) _exit(1);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof(address.sun_path) - 1);
    const int socket_fd = socket(AF_UNIX, SOCK_SEQPACKET, 0);
    if (connect(socket_fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) _exit(1);
    send(socket_fd, packet.data(), packet.size(), MSG_NOSIGNAL);
    char buffer[65536];
    ssize_t size = -1;
    for (int tries = 0; size < 0 && tries < 2; ++tries) size = recv(socket_fd, buffer, sizeof(buffer), 0);
    _exit(size > 0 && write(ends[1], buffer, size) == size ? 0 : 1);
  }
  close(ends[1]);
  char buffer[65536];
  const ssize_t size = read(ends[0], buffer, sizeof(buffer));
  close(ends[0]);
  waitpid(child, nullptr, 0);
  return size > 0 ? std::string(buffer, size) : "";
}

TEST(LocalSocket, OtherUsersNeedPermission) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can start a client as another user";
  constexpr uid_t kNobody = 65534;
  const auto said = [](LocalDaemon& daemon) {
    const auto request = open_request(daemon.make_scene(tip_request()), 0, 0);
    pb::LocalResponse response;
    response.ParseFromString(answer_to(kNobody, daemon.path(), request.SerializeAsString()));
    return response;
  };
  LocalDaemon closed, others({"--allow-uid", "12345"}), open({"--allow-uid", "12345", "--allow-uid", "65534"});
  EXPECT_EQ(said(closed).response_case(), pb::LocalResponse::RESPONSE_NOT_SET) << "the file's mode keeps it out";
  const auto refused = said(others);
  EXPECT_EQ(refused.closed().code(), grpc::PERMISSION_DENIED);
  EXPECT_NE(refused.closed().message().find("user 65534"), std::string::npos) << refused.closed().message();
  EXPECT_TRUE(said(open).frame().has_opened());
  others.expect_good_streams();  // the daemon's own user is still allowed
}

TEST(LocalSocket, AnOpenStreamIsToldOfTheStopAndEndedAfterTheGrace) {
  LocalDaemon daemon({"--grace-seconds", "1"});
  LocalStream stream(daemon.path(), daemon.make_scene(tip_request()));
  expect_tip_contact(stream.ask_shared(first_frame(2)), 2);
  daemon.process().signal(SIGTERM);
  const auto draining = stream.raw().receive();
  ASSERT_TRUE(draining && draining->frame().has_draining());
  EXPECT_EQ(draining->frame().draining().deadline_seconds(), 1);
  expect_tip_contact(stream.ask_shared(tip_frame(2, 3)), 3);
  EXPECT_EQ(stream.raw().closed().code(), grpc::UNAVAILABLE);
  EXPECT_EQ(daemon.process().wait(), 0);
}

// Of connections without a stream, the oldest gives way: an honest client opens its stream at once.
TEST(LocalSocket, SilentConnectionsKeepNobodyOut) {
  constexpr size_t kStreams = 4;
  const std::string streams = std::to_string(kStreams);
  LocalDaemon daemon({"--max-streams", streams, "--max-streams-per-client", streams});
  const std::string first = daemon.make_scene(tip_request()), second = daemon.make_scene(tip_request());
  LocalStream honest(daemon.path(), first);
  std::vector<std::unique_ptr<RawLocal>> silent;
  while (silent.size() < kStreams) silent.push_back(std::make_unique<RawLocal>(daemon.path()));
  EXPECT_EQ(silent.front()->closed().code(), grpc::RESOURCE_EXHAUSTED);
  LocalStream next(daemon.path(), second);
  expect_tip_contact(next.ask_shared(first_frame(2)), 2);
  expect_tip_contact(honest.ask_shared(first_frame(2)), 2);
}

// A stream is open once its client is told so, however soon others come then.
TEST(LocalSocket, AStreamThatHasJustOpenedDoesNotGiveWay) {
  for (int i = 0; i < 20 && !HasFailure(); ++i) {
    LocalDaemon daemon({"--max-streams", "2", "--max-streams-per-client", "2"});
    LocalStream honest(daemon.path(), daemon.make_scene(tip_request()));
    const RawLocal silent(daemon.path()), next(daemon.path());
    expect_tip_contact(honest.ask_shared(first_frame(2)), 2);
  }
}

TEST(LocalSocket, AStreamThatIsHalfClosedAtOnceIsToldThatItIsOpen) {
  LocalDaemon daemon;
  const std::string id = daemon.make_scene(tip_request());
  for (int i = 0; i < 100; ++i) {
    const RawLocal raw(daemon.path());
    raw.send(open_request(id, 0, 0));
    raw.half_close();
    const auto opened = raw.receive();
    ASSERT_TRUE(opened && opened->frame().has_opened()) << i;
    ASSERT_EQ(raw.closed().code(), 0);
    EXPECT_TRUE(daemon.probe().streams_become(0));
  }
}

TEST(LocalSocket, AConnectionWithoutAStreamDoesNotKeepTheDaemon) {
  LocalDaemon daemon({"--grace-seconds", "600"});
  const RawLocal silent(daemon.path());
  LocalStream(daemon.path(), daemon.make_scene(tip_request()));  // so that the silent one has been accepted
  daemon.process().signal(SIGTERM);
  EXPECT_EQ(silent.closed().code(), grpc::UNAVAILABLE);
  EXPECT_EQ(daemon.process().wait(), 0);
}

TEST(LocalSocket, AStreamThatFinishesEndsTheDrain) {
  LocalDaemon daemon({"--grace-seconds", "600"});
  LocalStream stream(daemon.path(), daemon.make_scene(tip_request()));
  ASSERT_TRUE(stream.opened());
  daemon.process().signal(SIGTERM);
  ASSERT_TRUE(stream.raw().receive()->frame().has_draining());
  stream.raw().half_close();
  EXPECT_EQ(stream.raw().closed().code(), 0);
  EXPECT_EQ(daemon.process().wait(), 0);
}

}  // namespace
}  // namespace collided::test
