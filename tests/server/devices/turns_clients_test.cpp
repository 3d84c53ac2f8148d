// Fair turns among clients: however many scenes they have, and however long their frames run.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "gpu/detector.hpp"
#include "server/devices/turns.hpp"
#include "tests/server/hand_clock.hpp"
#include "tests/server/wait_until.hpp"

namespace collided::server {
namespace {

using std::chrono::milliseconds;

class TurnsOfClients : public testing::Test {
 protected:
  Turns turns(unsigned concurrent, bool reserves_one = false) const {
    return Turns({.concurrent = concurrent, .reserves_one = reserves_one, .now = clock_.now()});
  }
  static bool is_free(Turns& turns, TurnAccount& account) {
    try {
      turns.take(account, [] { return true; });
      return true;
    } catch (const Cancelled&) {
      return false;
    }
  }

  const HandClock clock_;
};

/// A thread that waits for a turn and runs a function in it.
class Waiting {
 public:
  Waiting(Turns& turns, TurnAccount& account, const std::function<void()>& run)
      : thread_([this, &turns, &account, run] {
          const auto turn = turns.take(account, [this] { return !(waits_ = true); });
          run();
        }) {
    EXPECT_TRUE(wait_until([this] { return waits_.load(); }));
  }

 private:
  std::atomic<bool> waits_ = false;
  std::jthread thread_;
};

// A client with twenty scenes has no more turns than one with a single scene.
TEST_F(TurnsOfClients, HaveEqualTimeHoweverManyScenesTheyHave) {
  constexpr int kScenes = 20, kTurns = 15;
  Turns shared = turns(1);
  std::atomic<bool> modest_waits = false, is_over = false;
  std::atomic<int> of_greedy = 0;
  std::vector<std::jthread> threads;
  for (int i = 0; i < kScenes; ++i)
    threads.emplace_back([&] {
      TurnAccount account = shared.account({"greedy"});
      while (!is_over) {
        const auto turn = shared.take(account);
        wait_until([&] { return modest_waits || is_over; });
        if (is_over) break;
        clock_.move(milliseconds(5));
        ++of_greedy;
      }
    });
  TurnAccount account = shared.account({"modest"});
  ASSERT_TRUE(wait_until([&] { return !is_free(shared, account); }));
  for (int i = 0; i < kTurns; ++i) {
    const auto turn = shared.take(account, [&] { return !(modest_waits = true); });
    clock_.move(milliseconds(5));
    modest_waits = false;
  }
  is_over = true;
  EXPECT_LE(of_greedy, kTurns + 2);
}

TEST_F(TurnsOfClients, TheScenesOfOneAreFairAmongEachOther) {
  Turns shared = turns(1);
  TurnAccount much = shared.account({"a"}), little = shared.account({"a"}), holder = shared.account({"b"});
  std::string order;
  for (const auto& [account, time] : {std::pair{&much, 9}, {&little, 2}}) {
    const auto turn = shared.take(*account);
    clock_.move(milliseconds(time));
  }
  std::optional held = shared.take(holder);
  {
    const Waiting first(shared, much, [&] { order += 'm'; }), second(shared, little, [&] { order += 'l'; });
    held.reset();
  }
  EXPECT_EQ(order, "lm");
}

TEST_F(TurnsOfClients, AFrameGivesWayAfterItsQuantumToAnotherClientAlone) {
  Turns shared = turns(1);
  TurnAccount runs = shared.account({"a"}), brother = shared.account({"a"}), other = shared.account({"b"});
  std::string order;
  auto turn = std::make_optional(shared.take(runs));
  {
    const Waiting same(shared, brother, [&] { order += 's'; });
    clock_.move(milliseconds(50));
    turn->yield_turn();
    EXPECT_EQ(order, "");
    const Waiting another(shared, other, [&] {
      clock_.move(milliseconds(1));
      order += 'o';
    });
    turn->yield_turn();  // its new quantum has just begun
    EXPECT_EQ(order, "");
    clock_.move(Turns::kQuantum);
    turn->yield_turn();
    EXPECT_EQ(order, "os");  // of its own client, too, the one with less time is next
    order += 'r';
    turn.reset();
  }
  EXPECT_EQ(order, "osr");
}

TEST_F(TurnsOfClients, AFrameIsChargedForItsOwnTimeAlone) {
  Turns shared = turns(1);
  TurnAccount runs = shared.account({"a"}), other = shared.account({"b"});
  auto turn = shared.take(runs);
  clock_.move(milliseconds(20));
  {
    const Waiting another(shared, other, [&] { clock_.move(milliseconds(15)); });
    turn.yield_turn();
  }
  clock_.move(milliseconds(3));
  EXPECT_DOUBLE_EQ(turn.seconds(), 0.023);
}

// A client that has used more gets no turn, however long the other runs.
TEST_F(TurnsOfClients, NobodyGivesWayToOneThatHasHadMore) {
  Turns shared = turns(1);
  TurnAccount runs = shared.account({"a"}), other = shared.account({"b"});
  {
    const auto turn = shared.take(other);
    clock_.move(milliseconds(100));
  }
  std::string order;
  auto turn = std::make_optional(shared.take(runs));
  {
    const Waiting waits(shared, other, [&] { order += 'o'; });
    clock_.move(milliseconds(30));
    turn->yield_turn();
    EXPECT_EQ(order, "");
    clock_.move(milliseconds(80));
    turn->yield_turn();
    EXPECT_EQ(order, "o");
    turn.reset();
  }
}

// One client's long frame is no credit for those that arrive later.
TEST_F(TurnsOfClients, OneThatComesLateSavedNothingUp) {
  Turns shared = turns(1);
  TurnAccount runs = shared.account({"a"}), late = shared.account({"b"});
  auto turn = shared.take(runs);
  for (int i = 0; i < 100; ++i) {
    clock_.move(Turns::kQuantum);
    turn.yield_turn();
  }
  std::string order;
  {
    const Waiting waits(shared, late, [&] {
      order += 'l';
      clock_.move(milliseconds(500));
    });
    clock_.move(Turns::kQuantum);
    turn.yield_turn();
  }
  const Waiting again(shared, late, [&] { order += 'l'; });
  clock_.move(milliseconds(300));
  turn.yield_turn();
  EXPECT_EQ(order, "l");
  clock_.move(milliseconds(300));
  turn.yield_turn();
  EXPECT_EQ(order, "ll");
}

TEST_F(TurnsOfClients, AFrameThatIsCancelledWhileItGaveWayLosesNoTurn) {
  Turns shared = turns(1);
  TurnAccount runs = shared.account({"a"}), other = shared.account({"b"});
  std::atomic<bool> goes_on = false;
  {
    auto turn = shared.take(runs);
    const Waiting another(shared, other, [&] { wait_until([&] { return goes_on.load(); }); });
    clock_.move(Turns::kQuantum);
    EXPECT_THROW(turn.yield_turn([] { return true; }), Cancelled);
    EXPECT_FALSE(is_free(shared, runs));
    goes_on = true;
  }
  EXPECT_TRUE(wait_until([&] { return is_free(shared, runs); }));
  const auto held = shared.take(other);
  EXPECT_FALSE(is_free(shared, runs));
}

// If turns cannot yield, one client never holds them all, unless it is alone.
TEST_F(TurnsOfClients, OneTurnIsKeptFreeForOtherClients) {
  Turns shared = turns(3, true);
  std::array<TurnAccount, 3> accounts{shared.account({"a"}), shared.account({"a"}), shared.account({"a"})};
  const auto first = shared.take(accounts[0]), second = shared.take(accounts[1]);
  EXPECT_TRUE(is_free(shared, accounts[2]));
  {
    TurnAccount other = shared.account({"b"});
    EXPECT_FALSE(is_free(shared, accounts[2]));
    EXPECT_TRUE(is_free(shared, other));
  }
  EXPECT_TRUE(is_free(shared, accounts[2]));
}

// An address has its share however many connections it has; so has each of its connections.
TEST_F(TurnsOfClients, GroupsOfClientsHaveEqualTime) {
  Turns shared = turns(1);
  struct Loop {
    char name;
    TurnAccount account;
    std::optional<Turns::Turn> turn = std::nullopt;
  };
  std::deque<Loop> loops;
  for (const auto& [name, path] : {std::pair{'x', TurnPath{"one", "x"}},
                                   {'y', TurnPath{"one", "y"}},
                                   {'z', TurnPath{"one", "z"}},
                                   {'o', TurnPath{"other", "o"}}})
    loops.push_back({name, shared.account(path)});
  const auto ask = [&](Loop& loop) {
    shared.request(loop.account, [&](Turns::Turn turn) { loop.turn.emplace(std::move(turn)); });
  };
  for (Loop& loop : loops) ask(loop);
  std::map<char, int> had;
  const auto running = [&] {
    return std::ranges::find_if(loops, [](const Loop& loop) { return loop.turn.has_value(); });
  };
  for (int i = 0; i < 60; ++i) {
    const auto runs = running();
    ASSERT_NE(runs, loops.end());
    clock_.move(milliseconds(5));
    ++had[runs->name];
    runs->turn.reset();
    ask(*runs);
  }
  EXPECT_EQ(shared.waiting(), 3u);
  for (auto last = running(); last != loops.end(); last = running()) last->turn.reset();
  EXPECT_NEAR(had['o'], 30, 2);
  for (const char name : {'x', 'y', 'z'}) EXPECT_NEAR(had[name], 10, 2);
}

TEST_F(TurnsOfClients, AConnectionGivesWayToAnotherOfItsAddress) {
  Turns shared = turns(1);
  TurnAccount runs = shared.account({"address", "1"}), brother = shared.account({"address", "1"}),
              other = shared.account({"address", "2"});
  std::string order;
  auto turn = std::make_optional(shared.take(runs));
  {
    const Waiting same(shared, brother, [&] { order += 's'; });
    clock_.move(Turns::kQuantum);
    turn->yield_turn();
    EXPECT_EQ(order, "");
    const Waiting another(shared, other, [&] { order += 'o'; });
    clock_.move(Turns::kQuantum);
    turn->yield_turn();
    EXPECT_EQ(order.substr(0, 1), "o");
    turn.reset();
  }
}

// Between its calls a client may hold nothing: what it has used counts all the same.
TEST_F(TurnsOfClients, OneThatComesAgainIsNotNew) {
  Turns shared = turns(1);
  const auto use = [&](const char* client, int time) {
    TurnAccount account = shared.account({client});
    const auto turn = shared.take(account);
    clock_.move(milliseconds(time));
  };
  TurnAccount holder = shared.account({"holder"}), little = shared.account({"little"});
  use("much", 100);
  use("little", 20);
  std::optional held = shared.take(holder);
  std::string order;
  {
    TurnAccount much = shared.account({"much"});
    const Waiting first(shared, much, [&] { order += 'm'; }), second(shared, little, [&] { order += 'l'; });
    held.reset();
  }
  EXPECT_EQ(order, "lm");
}

TEST_F(TurnsOfClients, ASingleTurnIsKeptFreeForNobody) {
  Turns shared = turns(1, true);
  TurnAccount one = shared.account({"a"}), other = shared.account({"b"});
  EXPECT_TRUE(is_free(shared, one));
  EXPECT_TRUE(is_free(shared, other));
}

}  // namespace
}  // namespace collided::server
