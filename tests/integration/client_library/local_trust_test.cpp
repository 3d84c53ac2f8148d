// The C++ client checks who listens at a daemon's local socket before it sends a token there.
#include <grp.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <optional>
#include <utility>

#include "client/cpp/transport/local/local_peer.hpp"
#include "tests/integration/client_library/client_layers.hpp"
#include "tests/integration/local/local_daemon.hpp"

namespace collided::test {
namespace {

using client::Error;
using client::Local;

constexpr uid_t kNobody = 65534;
constexpr char kToken[] = "token-of-the-simulator";

/// A process of another user that listens at its own path, and keeps what the first connection sends.
class FakeDaemon {
 public:
  /// `user` must be able to write to the folder of `path`.
  FakeDaemon(const std::string& path, uid_t user, int kind = SOCK_SEQPACKET) {
    int said[2];
    EXPECT_EQ(pipe2(said, O_CLOEXEC), 0);
    child_ = fork();
    if (child_ == 0) _exit(be(path, user, kind, said[1]));
    close(said[1]);
    said_ = said[0];
    char ready = 0;
    EXPECT_EQ(read(said_, &ready, 1), 1) << "no fake daemon at " << path;
  }
  FakeDaemon(const FakeDaemon&) = delete;
  FakeDaemon& operator=(const FakeDaemon&) = delete;
  ~FakeDaemon() {
    if (child_ > 0) end();
    close(said_);
  }

  /// Everything that it received; ends it.
  std::string end() {
    kill(child_, SIGTERM);
    waitpid(std::exchange(child_, -1), nullptr, 0);
    std::string text;
    char buffer[4096];
    for (ssize_t n = 0; (n = read(said_, buffer, sizeof(buffer))) > 0;) text.append(buffer, n);
    return text;
  }

 private:
  static int be(const std::string& path, uid_t user, int kind, int said) {
    if (user != geteuid() && (setgroups(0, nullptr) != 0 || setgid(user) != 0 || setuid(user) != 0)) return 1;
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof(address.sun_path) - 1);
    const int listener = socket(AF_UNIX, kind | SOCK_CLOEXEC, 0);
    if (bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) return 1;
    if (chmod(path.c_str(), 0666) != 0 || listen(listener, 4) != 0 || write(said, "r", 1) != 1) return 1;
    for (;;) {
      const int connection = accept(listener, nullptr, nullptr);
      char buffer[65536];
      const ssize_t size = recv(connection, buffer, sizeof(buffer), 0);
      if (size > 0 && write(said, buffer, size) != size) return 1;
      close(connection);
    }
  }

  pid_t child_ = -1;
  int said_ = -1;
};

/// A daemon with a token, whose local socket another process has replaced.
class LocalTrust : public testing::Test {
 protected:
  LocalTrust() {
    char pattern[] = "/tmp/collided-trust-XXXXXX";
    folder_ = mkdtemp(pattern);
    tokens_ = folder_ + "/tokens.toml";
    std::ofstream(tokens_) << "[[tokens]]\nname = \"a\"\ntoken = \"" << kToken << "\"\n";
    chmod(tokens_.c_str(), 0600);
    sockets_ = folder_ + "/sockets";
    mkdir(sockets_.c_str(), 0755);
    daemon_.emplace(
        std::vector<std::string>{"--local-socket", socket(), "--tokens-file", tokens_, "--address", "127.0.0.1:0"});
  }
  ~LocalTrust() override {
    daemon_.reset();
    std::filesystem::remove_all(folder_);
  }

  std::string socket() const { return sockets_ + "/local"; }
  std::string tcp() const { return daemon_->tcp_address(); }
  std::string over_unix() const { return daemon_->address(); }
  void take_away_socket() const { ASSERT_EQ(unlink(socket().c_str()), 0); }

  /// A frame is served, over gRPC or shared memory, whatever the socket is.
  void open(const std::string& address, client::LocalOptions local = {}) {
    Client client = Client::connect(address, {.token = kToken});
    FrameStream stream = client.stream(make_layers(client), {.local = local});
    EXPECT_GT(ask_whole(stream, 1).vertex_triangle.count, 0u);
    is_local_ = stream.is_local();
    refusal_ = stream.local_refusal();
    EXPECT_NO_THROW(stream.finish());
  }
  void expect_refused(const std::string& address, const std::string& why) {
    open(address);
    EXPECT_FALSE(is_local_);
    EXPECT_NE(refusal_.find(why), std::string::npos) << refusal_;
    Client client = Client::connect(address, {.token = kToken});
    const pb::Scene scene = make_layers(client);
    try {
      client.stream(scene, {.local = {.use = Local::kOn}});
      ADD_FAILURE() << "it was opened";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), grpc::PERMISSION_DENIED) << e.what();
      EXPECT_NE(e.message().find(why), std::string::npos) << e.what();
    }
  }

  std::string folder_, tokens_, sockets_;
  std::optional<DaemonProcess> daemon_;
  bool is_local_ = false;
  std::string refusal_;
};

TEST_F(LocalTrust, TheDaemonsOwnSocketIsUsed) {
  for (const std::string& address : {tcp(), over_unix()}) {
    open(address);
    EXPECT_TRUE(is_local_);
    EXPECT_EQ(refusal_, "");
    open(address, {.use = Local::kOff});
    EXPECT_FALSE(is_local_);
    EXPECT_EQ(refusal_, "");
  }
}

TEST_F(LocalTrust, AnotherUsersSocketGetsNoToken) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can start a fake daemon as another user";
  take_away_socket();
  ASSERT_EQ(chmod(sockets_.c_str(), 01777), 0);
  chmod(folder_.c_str(), 0755);
  FakeDaemon fake(socket(), kNobody);
  for (const std::string& address : {tcp(), over_unix()}) expect_refused(address, "user 65534 listens at");
  EXPECT_EQ(fake.end(), "") << "nothing is sent to it";
}

TEST_F(LocalTrust, AUserWhoIsConfiguredMayListen) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can start a fake daemon as another user";
  take_away_socket();
  chmod(folder_.c_str(), 0755);
  ASSERT_EQ(chown(sockets_.c_str(), kNobody, kNobody), 0);
  FakeDaemon fake(socket(), kNobody);
  open(tcp(), {.daemon_user = kNobody});
  EXPECT_FALSE(is_local_);  // not a daemon
  EXPECT_NE(fake.end().find(kToken), std::string::npos) << "but it was asked";
}

TEST_F(LocalTrust, AFolderThatIsAnotherUsersIsRefused) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a folder to another user";
  ASSERT_EQ(chown(sockets_.c_str(), kNobody, kNobody), 0);
  expect_refused(tcp(), "belongs to user 65534");
}

TEST_F(LocalTrust, AFolderThatAllMayWriteToMustBeSticky) {
  ASSERT_EQ(chmod(sockets_.c_str(), 0777), 0);
  for (const std::string& address : {tcp(), over_unix()}) expect_refused(address, "not sticky");
  ASSERT_EQ(chmod(sockets_.c_str(), 01777), 0);
  open(tcp());
  EXPECT_TRUE(is_local_);
}

TEST_F(LocalTrust, WhyThereIsNoSharedMemoryIsTold) {
  take_away_socket();
  open(tcp());
  EXPECT_FALSE(is_local_);
  EXPECT_NE(refusal_.find("no daemon answers at " + socket()), std::string::npos) << refusal_;
}

// That user has the token already.
TEST_F(LocalTrust, WhoListensForGrpcMayListenForTheLocalSocket) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can start a fake daemon as another user";
  chmod(folder_.c_str(), 0755);
  ASSERT_EQ(chmod(sockets_.c_str(), 01777), 0);
  FakeDaemon other(sockets_ + "/grpc", kNobody, SOCK_STREAM);
  EXPECT_TRUE(client::TrustedUsers("unix:" + sockets_ + "/grpc", -1).contains(kNobody));
  EXPECT_TRUE(client::TrustedUsers("unix://" + sockets_ + "/grpc", -1).contains(kNobody));
  for (const std::string& address : {over_unix(), tcp(), std::string("unix:" + sockets_ + "/none")}) {
    client::TrustedUsers users(address, -1);
    EXPECT_TRUE(users.contains(geteuid()) && users.contains(0));
    EXPECT_FALSE(users.contains(kNobody)) << address;
  }
  other.end();
}

}  // namespace
}  // namespace collided::test
