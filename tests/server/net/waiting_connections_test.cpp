// Connections wait until their first bytes have come and it is their turn.
#include "server/net/waiting_connections.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <string>
#include <vector>

#include "server/net/sockets/peer.hpp"
#include "tests/server/net/tcp.hpp"

namespace collided::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class Waiting : public testing::Test {
 protected:
  /// A connection that has sent `bytes`. Returns its client's end.
  int come(const std::string& source, const std::string& bytes = "hello") {
    Pair& pair = pairs_.emplace_back(listener_);
    send(pair.client.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    EXPECT_TRUE(bytes.empty() || eventually([&] { return has_unread(pair.server.get()); }));
    waiting_.add({std::move(pair.server), pairs_.size() - 1, source});
    return pair.client.get();
  }
  void look(WaitingConnections::Clock::time_point now = WaitingConnections::Clock::now()) {
    std::vector<pollfd> states;
    waiting_.watch(states);
    poll(states.data(), states.size(), 0);
    waiting_.update(states.data(), now);
  }
  /// The number of the next connection; -1 if none may have its turn.
  int next(WaitingConnections::Clock::time_point now = WaitingConnections::Clock::now()) {
    auto connection = waiting_.next(now);
    if (!connection.fd) return -1;
    handed_over_.push_back(std::move(connection.fd));
    return static_cast<int>(connection.place);
  }
  static void read_all(const Fd& fd) {
    char buffer[64];
    while (recv(fd.get(), buffer, sizeof buffer, MSG_DONTWAIT) > 0) continue;
  }

  const Listener listener_{"127.0.0.1:0"};
  std::deque<Pair> pairs_;
  std::vector<Fd> handed_over_;
  WaitingConnections waiting_{4};
};

TEST_F(Waiting, WhoSendsNothingWaitsAndIsClosedAfterTenSeconds) {
  const int client = come("a", "");
  look();
  EXPECT_EQ(waiting_.size(), 1u);
  EXPECT_EQ(waiting_.ready(), 0u);
  EXPECT_EQ(next(), -1);
  look(WaitingConnections::Clock::now() + seconds(11));
  EXPECT_EQ(waiting_.size(), 0u);
  char byte;
  EXPECT_TRUE(eventually([&] { return recv(client, &byte, 1, MSG_DONTWAIT) == 0; }));
}

TEST_F(Waiting, AFewHaveUnreadBytesAtATime) {
  for (int i = 0; i < 6; ++i) come(std::to_string(i));
  look();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(next(), i);
  EXPECT_EQ(next(), -1);
  read_all(handed_over_[2]);
  EXPECT_EQ(next(), 4);
  EXPECT_EQ(next(), -1);
  handed_over_[0] = Fd();  // gRPC closes it
  EXPECT_EQ(next(), 5);
}

TEST_F(Waiting, WhatAClientThatLeftHadSentIsWorkUntilGrpcCloses) {
  for (int i = 0; i < 5; ++i) come(std::to_string(i));
  look();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(next(), i);
  pairs_[1].client = Fd();
  read_all(handed_over_[1]);
  EXPECT_EQ(next(), -1);
  handed_over_[1] = Fd();
  EXPECT_EQ(next(), 4);
}

TEST_F(Waiting, OnABusyMachineOthersHaveTheirTurnAfterASecond) {
  for (int i = 0; i < 5; ++i) come(std::to_string(i));
  look();
  const auto now = WaitingConnections::Clock::now();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(next(now), i);
  EXPECT_EQ(next(now + milliseconds(900)), -1);
  EXPECT_EQ(next(now + milliseconds(1100)), 4);
}

TEST_F(Waiting, WhoHasLeftIsNeverHandedOver) {
  for (int i = 0; i < 100; ++i) {
    come("a", std::string(1000, 'x'));
    pairs_.back().client = Fd();
  }
  come("b");
  look();
  EXPECT_EQ(waiting_.size(), 1u);
  EXPECT_EQ(next(), 100);
  EXPECT_EQ(next(), -1);
}

TEST_F(Waiting, WhereManyWaitForTheirTurnTheyWaitForTwoSeconds) {
  come("a", "");
  for (int i = 0; i < 32; ++i) come("a");
  look();
  look(WaitingConnections::Clock::now() + milliseconds(1500));
  EXPECT_EQ(waiting_.ready(), 32u);
  look(WaitingConnections::Clock::now() + milliseconds(2500));
  EXPECT_EQ(waiting_.ready(), 0u);
  EXPECT_EQ(waiting_.size(), 1u);
  for (int i = 0; i < 31; ++i) come("a");
  look();
  look(WaitingConnections::Clock::now() + seconds(9));
  EXPECT_EQ(waiting_.ready(), 31u);
}

TEST_F(Waiting, SourcesHaveTheirTurnsAndTheNewestOfEachComesFirst) {
  for (int i = 0; i < 10; ++i) come("many");
  come("one");
  come("other");
  look();
  std::vector<int> turns;
  for (int i = 0; i < 6; ++i) {
    turns.push_back(next());
    read_all(handed_over_.back());
  }
  EXPECT_EQ(turns, (std::vector<int>{9, 10, 11, 8, 7, 6}));
}

}  // namespace
}  // namespace collided::server
