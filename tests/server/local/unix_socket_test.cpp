// Who may listen on a path, and what is left of it.
#include "server/local/unix_socket.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <barrier>
#include <fstream>
#include <memory>
#include <thread>
#include <vector>

#include "tests/server/local/serving.hpp"

namespace collided::server {
namespace {

void leave_stale_socket(const std::string& path) {
  const Fd dead(socket(AF_UNIX, SOCK_SEQPACKET, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  ASSERT_EQ(bind(dead.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  EXPECT_TRUE(is_served(path));  // of another type than the one that asks
}

TEST(PacketListener, RemovesItsSocketAtTheEnd) {
  const Folder folder;
  const std::string path = folder.file("socket");
  {
    const PacketListener listener(path, 0600);
    struct stat file {};
    ASSERT_EQ(stat(path.c_str(), &file), 0);
    EXPECT_EQ(file.st_mode & 0777u, 0600u);
    EXPECT_TRUE(is_served(path));
    EXPECT_TRUE(RawLocal(path).is_connected());
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_FALSE(is_served(path));
}

TEST(PacketListener, TakesTheWaiterWithItsUser) {
  const Folder folder;
  const PacketListener listener(folder.file("socket"), 0600);
  EXPECT_FALSE(listener.accept());
  const RawLocal client(folder.file("socket"));
  const Fd connection = listener.accept();
  ASSERT_TRUE(connection);
  EXPECT_EQ(peer_uid(connection.get()), geteuid());
}

TEST(PacketListener, DoesNotTakeAPathFromAnother) {
  const Folder folder;
  const std::string path = folder.file("socket");
  const PacketListener first(path, 0600);
  EXPECT_THROW(PacketListener(path, 0600), std::runtime_error);
  EXPECT_TRUE(RawLocal(path).is_connected());
}

TEST(PacketListener, TakesAPathThatNobodyServes) {
  const Folder folder;
  const std::string path = folder.file("socket");
  leave_stale_socket(path);
  ASSERT_TRUE(std::filesystem::exists(path));
  const PacketListener listener(path, 0600);
  EXPECT_TRUE(RawLocal(path).is_connected());
}

TEST(PacketListener, OneOfSeveralTakesAStalePath) {
  constexpr int kRounds = 100, kDaemons = 4;
  const Folder folder;
  for (int round = 0; round < kRounds; ++round) {
    const std::string path = folder.file("socket" + std::to_string(round));
    leave_stale_socket(path);
    std::vector<std::unique_ptr<PacketListener>> listeners(kDaemons);
    std::vector<std::thread> threads;
    std::barrier begin(kDaemons);
    for (auto& listener : listeners)
      threads.emplace_back([&] {
        begin.arrive_and_wait();
        try {
          listener = std::make_unique<PacketListener>(path, 0600);
        } catch (const std::runtime_error&) {
        }
      });
    for (auto& thread : threads) thread.join();
    EXPECT_EQ(std::count_if(listeners.begin(), listeners.end(), [](const auto& one) { return one != nullptr; }), 1);
    EXPECT_TRUE(RawLocal(path).is_connected());
  }
}

TEST(PacketListener, LeavesOtherFilesAlone) {
  const Folder folder;
  const std::string path = folder.file("file");
  std::ofstream(path) << "mine";
  EXPECT_THROW(PacketListener(path, 0600), std::runtime_error);
  EXPECT_EQ(std::filesystem::file_size(path), 4u);
  EXPECT_THROW(PacketListener(folder.file(std::string(200, 'x')), 0600), std::runtime_error);
  EXPECT_THROW(PacketListener("", 0600), std::runtime_error);
}

TEST(PacketListener, LeavesASuccessorItsSocket) {
  const Folder folder;
  const std::string path = folder.file("socket");
  auto first = std::make_unique<PacketListener>(path, 0600);
  std::filesystem::remove(path);
  const PacketListener second(path, 0600);
  first.reset();
  EXPECT_TRUE(RawLocal(path).is_connected());
}

}  // namespace
}  // namespace collided::server
