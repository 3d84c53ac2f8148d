// Which connection is evicted from a full table.
#include "server/net/connections.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <string_view>
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
    EXPECT_TRUE(connections_.admit(pair.server.get(), peer));
    if (!client.empty()) connections_.identified(peer.name, client);
    return pair;
  }

  const Listener listener_{"127.0.0.1:0"};
  Connections connections_{3};
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

TEST_F(Table, AFloodOfFruitlessCallsEndsItsConnectionAndRefusesItsSource) {
  Pair& honest = add("honest");
  Pair& attacker = add();
  const std::string name = peer_of(attacker.server.get()).name;
  int calls = 1;
  while (!connections_.abandoned(name) && calls < 100'000) ++calls;
  EXPECT_EQ(calls, 1000);
  EXPECT_TRUE(attacker.is_ended());
  EXPECT_FALSE(connections_.abandoned(peer_of(honest.server.get()).name));
  EXPECT_FALSE(honest.is_ended());
  const Pair again(listener_);
  EXPECT_FALSE(connections_.admit(again.server.get(), peer_of(again.server.get())));
  EXPECT_TRUE(eventually([&] { return connections_.admit(again.server.get(), peer_of(again.server.get())); }));
}

/// Sends so many bytes and takes them at the other end, as gRPC would.
void send_through(Pair& pair, size_t size) {
  std::vector<char> bytes(4096), taken(4096);
  for (size_t sent = 0; sent < size; sent += bytes.size()) {
    ASSERT_EQ(send(pair.client.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL), ssize_t(bytes.size()));
    ASSERT_EQ(recv(pair.server.get(), taken.data(), taken.size(), MSG_WAITALL), ssize_t(taken.size()));
  }
}

TEST_F(Table, AFloodWithoutACallEndsItsConnectionAndRefusesItsSource) {
  Pair& client = add("a");
  Pair& checker = add();
  Pair& attacker = add();
  send_through(client, 2 << 20);
  send_through(checker, 512 << 10);
  send_through(attacker, 2 << 20);
  const auto ended = connections_.end_floods();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].peer, peer_of(attacker.server.get()).name);
  EXPECT_EQ(ended[0].what, "bytes without a call");
  EXPECT_FALSE(client.is_ended());
  EXPECT_FALSE(checker.is_ended());
  EXPECT_TRUE(attacker.is_ended());
  const Pair again(listener_);
  EXPECT_FALSE(connections_.admit(again.server.get(), peer_of(again.server.get())));
  EXPECT_EQ(connections_.evicted(), 1u);
}

TEST(Unfinished, TheMostOfAClientWhoseConnectionsHoldTooMuchIsEnded) {
  const Listener listener("127.0.0.1:0");
  Connections connections(8, 3 << 20);
  Pair large(listener), small(listener), other(listener);
  for (const Pair* const pair : {&large, &small, &other})
    ASSERT_TRUE(connections.admit(pair->server.get(), peer_of(pair->server.get())));
  connections.identified(peer_of(large.server.get()).name, "a");
  connections.identified(peer_of(small.server.get()).name, "a");
  connections.identified(peer_of(other.server.get()).name, "b");
  send_through(large, 2 << 20);
  send_through(small, 1 << 20);
  send_through(other, 2 << 20);
  EXPECT_TRUE(connections.end_floods().empty());
  send_through(small, 512 << 10);
  const auto ended = connections.end_floods();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].client, "a");
  EXPECT_TRUE(large.is_ended());
  EXPECT_FALSE(small.is_ended());
  EXPECT_FALSE(other.is_ended());
}

// Unix sockets cannot be told apart by their calls.
TEST(UnixTable, AFloodIsSeenInWhatIsUnread) {
  using std::string_view_literals::operator""sv;
  constexpr auto kReset = "\0\0\4\3\0\0\0\0\1\0\0\0\x8"sv, kSettings = "\0\0\0\4\0\0\0\0\0"sv;
  Connections connections(8);
  int honest[2], attacker[2];
  for (int* const pair : {honest, attacker}) {
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair), 0);
    EXPECT_TRUE(connections.admit(pair[0], {"unix:", pair == honest ? "pid:1" : "pid:2", true}));
  }
  const Fd all[] = {Fd(honest[0]), Fd(honest[1]), Fd(attacker[0]), Fd(attacker[1])};
  EXPECT_EQ(send(honest[1], kSettings.data(), kSettings.size(), 0), static_cast<ssize_t>(kSettings.size()));
  const auto flood = [&] {
    bool is_ended = false;
    for (int i = 0; i < 2000; ++i) is_ended |= connections.abandoned("unix:");
    return is_ended;
  };
  EXPECT_FALSE(flood());
  for (int i = 0; i < 100; ++i) send(attacker[1], kReset.data(), kReset.size(), 0);
  EXPECT_TRUE(flood());
  char byte;
  EXPECT_EQ(recv(attacker[1], &byte, 1, MSG_DONTWAIT), 0);
  EXPECT_EQ(recv(honest[1], &byte, 1, MSG_DONTWAIT), -1);
  EXPECT_FALSE(connections.admit(attacker[0], {"unix:", "pid:2", true}));
}

TEST(ConnectionLimit, LeavesDescriptorsForTheRest) {
  EXPECT_EQ(connections_for(1024, 0), 512u);
  EXPECT_EQ(connections_for(1'048'576, 0), 1024u);
  EXPECT_EQ(connections_for(1'048'576, 5000), 5000u);
  EXPECT_EQ(connections_for(1024, 5000), 768u);
}

}  // namespace
}  // namespace collided::server
