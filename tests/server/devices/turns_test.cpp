// Fair turns: who goes next, no starvation, and cancelled waits.
#include "server/devices/turns.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "gpu/detector.hpp"
#include "tests/server/wait_until.hpp"

namespace collided::server {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// Takes a turn of at least `time`; returns an upper bound of its length.
Clock::duration charge(Turns& turns, TurnAccount& account, Clock::duration time) {
  const auto begin = Clock::now();
  {
    const auto turn = turns.take(account);
    std::this_thread::sleep_for(time);
  }
  return Clock::now() - begin;
}

bool is_free(Turns& turns) {
  TurnAccount account;
  try {
    turns.take(account, [] { return true; });
    return true;
  } catch (const Cancelled&) {
    return false;
  }
}

// Threads that wait for a turn, one after the other, while the test holds the only one.
class Queue {
 public:
  explicit Queue(Turns& turns) : turns_(turns), held_(turns.take(holder_)) {}
  ~Queue() { release(); }

  /// Returns once it waits.
  void join(TurnAccount& account, char name) {
    std::atomic<bool> waits = false;
    threads_.emplace_back([this, &account, name, &waits] {
      const auto turn = turns_.take(account, [&waits, seen = false]() mutable {
        if (!seen) waits = true;
        seen = true;
        return false;
      });
      order_ += name;  // turns are one at a time
    });
    EXPECT_TRUE(wait_until([&] { return waits.load(); }));
  }
  void release() {
    held_.reset();
    for (auto& thread : threads_) thread.join();
    threads_.clear();
  }
  const std::string& order() const { return order_; }

 private:
  Turns& turns_;
  TurnAccount holder_;
  std::optional<Turns::Turn> held_;
  std::vector<std::thread> threads_;
  std::string order_;
};

TEST(Turns, TheAccountWithTheLeastTimeGoesNext) {
  Turns turns(1);
  TurnAccount most, some, none;
  const auto time = charge(turns, some, milliseconds(2));
  charge(turns, most, time + milliseconds(2));
  Queue queue(turns);
  queue.join(most, 'm');
  queue.join(some, 's');
  queue.join(none, 'n');
  queue.release();
  EXPECT_EQ(queue.order(), "nsm");
}

TEST(Turns, OfEqualsTheFirstGoesNext) {
  Turns turns(1);
  std::array<TurnAccount, 4> accounts;
  Queue queue(turns);
  for (size_t i = 0; i < accounts.size(); ++i) queue.join(accounts[i], "abcd"[i]);
  queue.release();
  EXPECT_EQ(queue.order(), "abcd");
}

// If the idle one accrued credit, it would go first again and again.
TEST(Turns, AnIdleAccountDoesNotSaveUpTurns) {
  Turns turns(1);
  TurnAccount busy, idle;
  Clock::duration last{};
  for (int i = 0; i < 10; ++i) last = charge(turns, busy, milliseconds(10));
  charge(turns, idle, last + milliseconds(2));
  Queue queue(turns);
  queue.join(idle, 'i');
  queue.join(busy, 'b');
  queue.release();
  EXPECT_EQ(queue.order(), "bi");
}

TEST(Turns, ACancelledWaitLeavesTheQueue) {
  Turns turns(1);
  TurnAccount first, second;
  std::atomic<bool> waits = false, cancelled = false;
  const auto is_cancelled = [&] {
    waits = true;
    return cancelled.load();
  };
  Queue queue(turns);
  std::thread waiter([&] { EXPECT_THROW(turns.take(first, is_cancelled), Cancelled); });
  EXPECT_TRUE(wait_until([&] { return waits.load(); }));
  queue.join(second, 's');
  cancelled = true;
  waiter.join();
  queue.release();
  EXPECT_EQ(queue.order(), "s");
  charge(turns, first, milliseconds(0));
  EXPECT_TRUE(is_free(turns));
}

// A hundred that wait ask together about as often as sixteen do.
TEST(Turns, TheMoreWaitTheLessOftenEachAsksWhetherItIsCancelled) {
  constexpr int kWaiters = 100;
  Turns turns(1);
  std::vector<TurnAccount> accounts(kWaiters + 1);
  std::atomic<int> asked = 0, cancelled = 0;
  std::atomic<bool> is_over = false;
  std::vector<std::thread> threads;
  {
    const auto held = turns.take(accounts[kWaiters]);
    for (int i = 0; i < kWaiters; ++i)
      threads.emplace_back([&, i] {
        try {
          turns.take(accounts[i], [&] { return ++asked, is_over.load(); });
        } catch (const Cancelled&) {
          ++cancelled;
        }
      });
    ASSERT_TRUE(wait_until([&] { return asked >= kWaiters; }));
    const auto begin = Clock::now();
    const int before = asked;
    std::this_thread::sleep_for(milliseconds(300));
    const int asks = asked - before;
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    EXPECT_LT(asks, kWaiters * (seconds / 0.06 + 1)) << "in " << seconds << " s";
    is_over = true;
    ASSERT_TRUE(wait_until([&] { return cancelled == kWaiters; }));
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(Turns, ATurnThatIsFreeIsNotCancelled) {
  Turns turns(1);
  TurnAccount account;
  EXPECT_NO_THROW(turns.take(account, [] { return true; }));
}

TEST(Turns, AsManyRunBesideEachOtherAsWereAllowed) {
  Turns turns(3);
  std::array<TurnAccount, 3> accounts;
  std::vector<Turns::Turn> held;
  for (auto& account : accounts) {
    EXPECT_TRUE(is_free(turns));
    held.push_back(turns.take(account));
  }
  EXPECT_FALSE(is_free(turns));
  held.pop_back();
  EXPECT_TRUE(is_free(turns));
}

TEST(Turns, ATurnThatWasMovedEndsOnce) {
  Turns turns(1);
  TurnAccount account;
  {
    Turns::Turn turn = turns.take(account);
    const Turns::Turn moved = std::move(turn);
    EXPECT_FALSE(is_free(turns));
  }
  const auto held = turns.take(account);
  EXPECT_FALSE(is_free(turns));
}

TEST(Turns, NobodyStarvesAmongManyThreads) {
  constexpr int kAtOnce = 2, kTurns = 50;
  Turns turns(kAtOnce);
  std::atomic<bool> stop = false;
  std::atomic<int> running = 0, most = 0;
  std::array<std::atomic<int>, 6> greedy{};
  const auto work = [&](TurnAccount& account, std::atomic<int>& count) {
    const auto turn = turns.take(account, [] { return false; });
    for (int now = ++running, seen = most; now > seen && !most.compare_exchange_weak(seen, now);) continue;
    std::this_thread::sleep_for(std::chrono::microseconds(100));
    ++count;
    --running;
  };
  std::vector<std::thread> threads;
  for (auto& count : greedy)
    threads.emplace_back([&] {
      TurnAccount account;
      while (!stop) work(account, count);
    });
  TurnAccount account;
  std::atomic<int> modest = 0;
  while (modest < kTurns) work(account, modest);
  EXPECT_TRUE(wait_until([&] { return std::all_of(greedy.begin(), greedy.end(), [](auto& n) { return n > 0; }); }));
  stop = true;
  for (auto& thread : threads) thread.join();
  EXPECT_LE(most, kAtOnce);
  EXPECT_TRUE(is_free(turns));
}

TEST(Turns, WaitsThatAreCancelledFromManyThreadsLoseNoTurn) {
  Turns turns(2);
  std::vector<std::thread> threads;
  std::atomic<int> done = 0, cancelled = 0;
  for (int t = 0; t < 6; ++t)
    threads.emplace_back([&, impatient = t % 2 == 0] {
      TurnAccount account;
      for (int i = 0; i < 30; ++i) try {
          const auto turn = turns.take(account, [&] { return impatient; });
          std::this_thread::sleep_for(milliseconds(1));
          ++done;
        } catch (const Cancelled&) {
          ++cancelled;
        }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(done + cancelled, 6 * 30);
  TurnAccount a, b;
  const auto one = turns.take(a), two = turns.take(b);
  EXPECT_FALSE(is_free(turns));
}

}  // namespace
}  // namespace collided::server
