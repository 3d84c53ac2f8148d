// Listening on a path, and removing it.
#include "server/net/sockets/unix_listener.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <barrier>
#include <fstream>
#include <memory>
#include <thread>
#include <vector>

#include "server/net/sockets/peer.hpp"
#include "tests/server/transport/local/serving.hpp"

namespace collided::server {
namespace {

constexpr UnixListener::Options kPackets{SOCK_SEQPACKET, 0600};

void leave_stale_socket(const std::string& path) {
  const Fd dead(socket(AF_UNIX, SOCK_SEQPACKET, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  ASSERT_EQ(bind(dead.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  EXPECT_TRUE(is_served(path));  // of another type than the probe
}

TEST(UnixListener, RemovesItsSocketAtTheEnd) {
  const Folder folder;
  const std::string path = folder.file("socket");
  {
    const UnixListener listener(path, kPackets);
    struct stat file {};
    ASSERT_EQ(stat(path.c_str(), &file), 0);
    EXPECT_EQ(file.st_mode & 0777u, 0600u);
    EXPECT_TRUE(is_served(path));
    EXPECT_TRUE(RawLocal(path).is_connected());
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_FALSE(is_served(path));
}

TEST(UnixListener, TakesTheWaiterWithItsUser) {
  const Folder folder;
  const UnixListener listener(folder.file("socket"), kPackets);
  EXPECT_FALSE(listener.accept());
  const RawLocal client(folder.file("socket"));
  const Fd connection = listener.accept();
  ASSERT_TRUE(connection);
  EXPECT_EQ(peer_uid(connection.get()), geteuid());
}

TEST(UnixListener, DoesNotTakeAPathFromAnother) {
  const Folder folder;
  const std::string path = folder.file("socket");
  const UnixListener first(path, kPackets);
  EXPECT_THROW(UnixListener(path, kPackets), std::runtime_error);
  EXPECT_TRUE(RawLocal(path).is_connected());
}

TEST(UnixListener, TakesAPathThatNobodyServes) {
  const Folder folder;
  const std::string path = folder.file("socket");
  leave_stale_socket(path);
  ASSERT_TRUE(std::filesystem::exists(path));
  const UnixListener listener(path, kPackets);
  EXPECT_TRUE(RawLocal(path).is_connected());
}

TEST(UnixListener, OneOfSeveralTakesAStalePath) {
  constexpr int kRounds = 100, kDaemons = 4;
  const Folder folder;
  for (int round = 0; round < kRounds; ++round) {
    const std::string path = folder.file("socket" + std::to_string(round));
    leave_stale_socket(path);
    std::vector<std::unique_ptr<UnixListener>> listeners(kDaemons);
    std::vector<std::thread> threads;
    std::barrier begin(kDaemons);
    for (auto& listener : listeners)
      threads.emplace_back([&] {
        begin.arrive_and_wait();
        try {
          listener = std::make_unique<UnixListener>(path, kPackets);
        } catch (const std::runtime_error&) {
        }
      });
    for (auto& thread : threads) thread.join();
    EXPECT_EQ(std::count_if(listeners.begin(), listeners.end(), [](const auto& one) { return one != nullptr; }), 1);
    EXPECT_TRUE(RawLocal(path).is_connected());
  }
}

TEST(UnixListener, LeavesOtherFilesAlone) {
  const Folder folder;
  const std::string path = folder.file("file");
  std::ofstream(path) << "mine";
  EXPECT_THROW(UnixListener(path, kPackets), std::runtime_error);
  EXPECT_EQ(std::filesystem::file_size(path), 4u);
  EXPECT_THROW(UnixListener(folder.file(std::string(200, 'x')), kPackets), std::runtime_error);
  EXPECT_THROW(UnixListener("", kPackets), std::runtime_error);
}

TEST(UnixListener, LeavesASuccessorItsSocket) {
  const Folder folder;
  const std::string path = folder.file("socket");
  auto first = std::make_unique<UnixListener>(path, kPackets);
  std::filesystem::remove(path);
  const UnixListener second(path, kPackets);
  first.reset();
  EXPECT_TRUE(RawLocal(path).is_connected());
}

}  // namespace
}  // namespace collided::server
