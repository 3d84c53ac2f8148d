// Connections are accepted, and a temporary lack of descriptors loses none.
#include "server/net/accept_loop.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <mutex>
#include <vector>

#include "server/net/admission_probe.hpp"
#include "tests/server/net/tcp.hpp"
#include "tests/support/sanitized.hpp"

namespace collided::server {
namespace {

class Loop : public testing::Test {
 protected:
  size_t taken() const {
    const std::lock_guard lock(mutex_);
    return taken_.size();
  }

  const Listener listener_{"127.0.0.1:0"};
  Connections connections_{{64, 64}};
  mutable std::mutex mutex_;
  std::vector<Fd> taken_;
  AcceptLoop loop_{listener_.sockets(), connections_, [this](Fd connection, size_t) {
                     const std::lock_guard lock(mutex_);
                     taken_.push_back(std::move(connection));
                   }};
};

TEST_F(Loop, TakesThoseWhoCome) {
  const Fd one = connect_to(listener_), two = connect_to(listener_);
  EXPECT_TRUE(eventually([&] { return taken() == 2; }));
  EXPECT_EQ(connections_.size(), 2u);
  EXPECT_EQ(loop_.shortage(), "");
}

TEST_F(Loop, GoesOnOnceThereIsADescriptorAgain) {
  if (test::kIsSanitized) GTEST_SKIP() << "the sanitizer needs descriptors, to look at memory";
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const Fd early = connect_to(listener_);
  EXPECT_TRUE(eventually([&] { return taken() == 1; }));
  const Fd late(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in to{};
  socklen_t size = sizeof(to);
  getsockname(listener_.sockets().front(), reinterpret_cast<sockaddr*>(&to), &size);
  const rlimit none{0, before.rlim_max};
  setrlimit(RLIMIT_NOFILE, &none);
  EXPECT_EQ(connect(late.get(), reinterpret_cast<const sockaddr*>(&to), sizeof(to)), 0);
  EXPECT_TRUE(eventually([&] { return !loop_.shortage().empty(); }));
  EXPECT_NE(loop_.shortage().find("Too many open files"), std::string::npos) << loop_.shortage();
  EXPECT_EQ(taken(), 1u);
  setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_TRUE(eventually([&] { return loop_.shortage().empty(); }));
  EXPECT_EQ(taken(), 2u);
}

// A process that runs out of descriptors right after the last waiting connection.
TEST(Descriptors, OfNobodyWhoWaitsAreNotMissed) {
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const rlimit none{1, before.rlim_max};  // 0 would be too few for poll()
  const Listener listener("127.0.0.1:0");
  Connections connections({64, 64});
  const Fd client = connect_to(listener), other = connect_to(listener);
  std::atomic<size_t> taken = 0;
  std::vector<Fd> kept;
  AcceptLoop loop(listener.sockets(), connections, [&](Fd connection, size_t) {
    kept.push_back(std::move(connection));
    if (kept.size() == 2) setrlimit(RLIMIT_NOFILE, &none);
    taken = kept.size();
  });
  EXPECT_TRUE(eventually([&] { return taken == 2; }));
  loop.stop();
  setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_EQ(loop.shortage(), "");
  EXPECT_EQ(connections.size(), 2u);  // none was ended
}

TEST(Probe, TellsTroubleAtOnceThoughAKnockWaits) {
  const Listener listener("127.0.0.1:0");  // nobody accepts
  std::mutex mutex;
  std::string told;
  int asked = 0;
  const AdmissionProbe probe(
      {{listener.sockets().front(), false, "here"}},
      [&] {
        const std::lock_guard lock(mutex);
        return ++asked < 3 ? std::string() : "no room";  // by then a probe waits for its answer
      },
      [&](const std::string& obstacle) {
        const std::lock_guard lock(mutex);
        if (told.empty()) told = obstacle;
      });
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return !told.empty();
  }));
  EXPECT_EQ(told, "no room");
}

TEST(Probe, TellsThatNobodyGetsIn) {
  const Listener listener("127.0.0.1:0");
  Connections connections({64, 64});
  AcceptLoop closing(listener.sockets(), connections, [](Fd connection, size_t) { connection = Fd(); });
  EXPECT_NE(probe({listener.sockets().front(), false, "here"}), "");
}

TEST(Listening, TellsTheReason) {
  const Listener listener("127.0.0.1:0");
  for (const auto& [address, why] : {std::pair<std::string, std::string>{listener.address(), "Address already in use"},
                                     {"unix:/nowhere/socket", "No such file or directory"},
                                     {"no.such.host.invalid:1", "cannot listen on no.such.host.invalid:1: "}}) {
    try {
      const Listener second(address);
      FAIL() << address;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace collided::server
