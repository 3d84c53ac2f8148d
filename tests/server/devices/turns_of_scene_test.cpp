// Scenes on several devices: a turn on each, or on none, and nobody waits forever.
#include "server/devices/turns_of_scene.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "gpu/detector.hpp"

namespace collided::server {
namespace {

bool is_free(Turns& turns) {
  TurnAccount account;
  try {
    turns.take(account, [] { return true; });
    return true;
  } catch (const Cancelled&) {
    return false;
  }
}

TEST(TurnsOfAScene, AreOnAllItsDevicesWhileTheyLast) {
  Turns first(1), second(1), other(1);
  TurnsOfScene scene({&first, &second}, {"robot"});
  {
    const auto turn = scene.take({});
    EXPECT_TRUE(!is_free(first) && !is_free(second) && is_free(other));
    EXPECT_GE(turn.seconds(), 0);
  }
  EXPECT_TRUE(is_free(first) && is_free(second));
  EXPECT_GT(first.busy_seconds(), 0);
  EXPECT_GT(second.busy_seconds(), 0);
}

TEST(TurnsOfAScene, ACancelledWaitForOneGivesTheOthersBack) {
  Turns first(1), second(1);
  TurnsOfScene scene({&first, &second}, {"robot"});
  TurnAccount account;
  const auto busy = second.take(account);
  EXPECT_THROW(scene.take([] { return true; }), Cancelled);
  EXPECT_TRUE(is_free(first));
}

TEST(TurnsOfAScene, AreChargedToWhoSendsItsFrames) {
  Turns turns(1);
  TurnsOfScene scene({&turns}, {"creator"});
  scene.charge_to({"sender"});
  TurnAccount creator = turns.account({"creator"}), sender = turns.account({"sender"}), holder = turns.account({"h"});
  {
    auto turn = scene.take({});
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::string order;
  auto held = std::make_optional(turns.take(holder));
  std::deque<Turns::Turn> granted;
  const auto ask = [&](TurnAccount& account, char name) {
    turns.request(account, [&order, &granted, name](Turns::Turn turn) {
      order += name;
      granted.push_back(std::move(turn));
    });
  };
  ask(sender, 's');
  ask(creator, 'c');
  held.reset();
  std::optional<Turns::Turn> first(std::move(granted.front()));
  granted.pop_front();
  first.reset();
  EXPECT_EQ(order, "cs");
}

// Each would otherwise wait for what the other has.
TEST(TurnsOfAScene, ScenesOnTheSameDevicesNeverBlockEachOther) {
  Turns first(1), second(1);
  std::vector<std::thread> threads;
  for (const char* client : {"a", "b", "c"})
    threads.emplace_back([&, client] {
      TurnsOfScene scene({&first, &second}, {client});
      for (int frame = 0; frame < 200; ++frame) {
        auto turn = scene.take({});
        turn.yield_turn({});
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(is_free(first) && is_free(second));
}

}  // namespace
}  // namespace collided::server
