// Which connection is evicted from a full table.
#include "server/net/connections.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <string>
#include <vector>

#include "server/net/sockets/descriptors.hpp"
#include "tests/server/net/tcp.hpp"

namespace collided::server {
namespace {

class Table : public testing::Test {
 protected:
  Pair& add(const std::string& client = "") {
    Pair& pair = pairs_.emplace_back(listener_);
    const Peer peer = peer_of(pair.server.get());
    connections_.admit(pair.server.get(), peer);
    if (!client.empty()) connections_.identified(peer.name, client);
    return pair;
  }

  const Listener listener_{"127.0.0.1:0"};
  Connections connections_{{3, 3}};
  std::deque<Pair> pairs_;
};

TEST_F(Table, TheOldestWithoutACallGoesFirst) {
  add("a");
  add();
  add();
  EXPECT_EQ(connections_.size(), 3u);
  add();
  EXPECT_EQ(connections_.size(), 3u);
  EXPECT_EQ(connections_.evicted(), 1u);
  EXPECT_FALSE(pairs_[0].is_ended());
  EXPECT_TRUE(pairs_[1].is_ended());
  EXPECT_FALSE(pairs_[2].is_ended());
}

TEST_F(Table, WhereAllMadeCallsTheClientWithMostGivesOne) {
  add("one");
  add("many");
  add("many");
  add("new");
  EXPECT_FALSE(pairs_[0].is_ended());
  EXPECT_TRUE(pairs_[1].is_ended());
  EXPECT_FALSE(pairs_[2].is_ended());
}

TEST_F(Table, TheOwnerMayCloseAtAnyTime) {
  for (int i = 0; i < 3; ++i) add();
  const Pair other(listener_);  // not in the table, but with the number of one that was
  dup2(other.server.get(), pairs_[0].server.get());
  connections_.evict(3);
  EXPECT_FALSE(other.is_ended());
  EXPECT_TRUE(pairs_[1].is_ended());
  EXPECT_EQ(connections_.size(), 0u);
}

TEST_F(Table, AFloodOfFruitlessCallsEndsItsConnectionAlone) {
  Pair& honest = add("honest");
  Pair& attacker = add("attacker");
  const auto calls_until_end = [&](const Pair& pair) {
    const std::string name = peer_of(pair.server.get()).name;
    int calls = 1;
    while (!connections_.abandoned(name) && calls < 100'000) ++calls;
    return calls;
  };
  EXPECT_EQ(calls_until_end(attacker), 1000);
  EXPECT_TRUE(attacker.is_ended());
  EXPECT_FALSE(connections_.abandoned(peer_of(honest.server.get()).name));
  EXPECT_FALSE(honest.is_ended());
  Pair& again = add();  // from the same address
  EXPECT_FALSE(again.is_ended());
  EXPECT_EQ(calls_until_end(again), 256);  // its caller is not known
  EXPECT_EQ(connections_.evicted(), 2u);
}

TEST_F(Table, AConnectionMakesFewCallsWithoutAKnownCaller) {
  Pair& client = add("a");
  Pair& guesser = add();
  const std::string name = peer_of(guesser.server.get()).name;
  for (int i = 1; i < 256; ++i) EXPECT_FALSE(connections_.called(name)) << i;
  EXPECT_FALSE(guesser.is_ended());
  EXPECT_TRUE(connections_.called(name));
  EXPECT_TRUE(guesser.is_ended());
  for (int i = 0; i < 5000; ++i) EXPECT_FALSE(connections_.called(peer_of(client.server.get()).name));
  EXPECT_FALSE(client.is_ended());
}

/// Sends so many bytes and takes them at the other end, as gRPC would.
void send_through(Pair& pair, size_t size) {
  std::vector<char> bytes(1 << 20), taken(1 << 16);
  for (size_t sent = 0; sent < size;) {
    const ssize_t now = send(pair.client.get(), bytes.data(), std::min(bytes.size(), size - sent), MSG_DONTWAIT);
    sent += static_cast<size_t>(std::max<ssize_t>(now, 0));
    while (recv(pair.server.get(), taken.data(), taken.size(), MSG_DONTWAIT) > 0) continue;
  }
}

TEST_F(Table, AConnectionHasBytesAndTimeBeforeItsFirstCall) {
  Pair& client = add("a");
  Pair& flood = add();
  Pair& silent = add();
  connections_.called(peer_of(client.server.get()).name);
  send_through(client, 65 << 20);
  send_through(flood, 63 << 20);
  EXPECT_TRUE(connections_.end_callless().empty());
  send_through(flood, 2 << 20);
  const auto ended = connections_.end_callless();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].peer, peer_of(flood.server.get()).name);
  EXPECT_TRUE(flood.is_ended());
  EXPECT_FALSE(silent.is_ended());
  EXPECT_TRUE(connections_.end_callless(Connections::Clock::now() + std::chrono::seconds(59)).empty());
  EXPECT_EQ(connections_.end_callless(Connections::Clock::now() + std::chrono::seconds(61)).size(), 1u);
  EXPECT_TRUE(silent.is_ended());
  EXPECT_FALSE(client.is_ended());
}

TEST(PeerLimit, APeerThatHasTooManyLosesItsOwn) {
  const Listener listener("127.0.0.1:0");
  Connections connections({8, 2});
  std::deque<Pair> pairs;
  for (const char* source : {"one", "other", "one", "one", "other"}) {
    Peer peer = peer_of(pairs.emplace_back(listener).server.get());
    peer.source = source;
    connections.admit(pairs.back().server.get(), peer);
    connections.identified(peer.name, "a");
  }
  EXPECT_TRUE(pairs[0].is_ended());
  for (size_t i = 1; i < pairs.size(); ++i) EXPECT_FALSE(pairs[i].is_ended()) << i;
}

/// Both ends of a connection over a Unix socket.
struct UnixPair {
  UnixPair() {
    int both[2];
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, both), 0);
    server = Fd(both[0]);
    client = Fd(both[1]);
  }
  bool is_ended() const {
    char byte;
    return recv(client.get(), &byte, 1, MSG_DONTWAIT) == 0;
  }
  Fd server, client;
};

TEST(UnixTable, UsersAreDifferentPeers) {
  const UnixPair pair;
  const Peer peer = peer_of(pair.server.get());
  EXPECT_TRUE(peer.is_unix);
  EXPECT_EQ(peer.source, "uid:" + std::to_string(getuid()));
  Connections connections({4, 4});
  std::deque<UnixPair> pairs;
  const auto add = [&](const std::string& user) {
    connections.admit(pairs.emplace_back().server.get(), {"unix:", user, true});
    connections.handed_over(pairs.back().server.get());
  };
  for (const char* user : {"uid:1", "uid:2", "uid:2", "uid:2"}) add(user);
  add("uid:3");
  EXPECT_FALSE(pairs[0].is_ended());
  EXPECT_TRUE(pairs[1].is_ended());  // the oldest of the user with the most
}

TEST(UnixTable, WhoSentNothingYetGoesFirst) {
  Connections connections({2, 2});
  std::deque<UnixPair> pairs(3);
  const auto admit = [&](size_t i) { connections.admit(pairs[i].server.get(), {"unix:", "uid:1", true}); };
  admit(0);
  connections.handed_over(pairs[0].server.get());
  admit(1);
  admit(2);
  EXPECT_FALSE(pairs[0].is_ended());
  EXPECT_TRUE(pairs[1].is_ended());
}

TEST(ConnectionLimit, LeavesDescriptorsForTheRest) {
  EXPECT_EQ(connections_for(1024, 0), 512u);
  EXPECT_EQ(connections_for(1'048'576, 0), 1024u);
  EXPECT_EQ(connections_for(1'048'576, 5000), 5000u);
  EXPECT_EQ(connections_for(1024, 5000), 768u);
}

}  // namespace
}  // namespace collided::server
