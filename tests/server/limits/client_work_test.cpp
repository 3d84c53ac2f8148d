// Work for calls of clients: in fair turns, on few threads.
#include "server/limits/client_work.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <string>

#include "tests/server/hand_clock.hpp"
#include "tests/server/wait_until.hpp"

namespace collided::server {
namespace {

using std::chrono::milliseconds;

class Work : public testing::Test {
 protected:
  /// All that is posted waits meanwhile.
  void hold() { held_.emplace(turns_.take(holder_)); }
  void release() {
    held_.reset();
    EXPECT_TRUE(wait_until([&] { return work_.size() == 0; }));
  }
  void post(const char* client, char name) {
    work_.post({client}, [this, name] {
      order_ += name;  // jobs are one at a time
      clock_.move(milliseconds(5));
    });
  }

  const HandClock clock_;
  Turns turns_{{.concurrent = 1, .now = clock_.now()}};
  TurnAccount holder_ = turns_.account({"holder"});
  std::optional<Turns::Turn> held_;
  std::string order_;
  ClientWork work_{turns_};
};

TEST_F(Work, OfOneClientIsDoneInOrder) {
  hold();
  for (const char name : {'a', 'b', 'c', 'd'}) post("one", name);
  EXPECT_EQ(work_.size(), 4u);
  EXPECT_EQ(order_, "");
  release();
  EXPECT_EQ(order_, "abcd");
}

TEST_F(Work, OfOneClientDoesNotWaitBehindAnothers) {
  hold();
  for (int i = 0; i < 50; ++i) post("greedy", 'g');
  for (int i = 0; i < 3; ++i) post("modest", 'm');
  release();
  EXPECT_EQ(order_.substr(0, 6), "gmgmgm");
  EXPECT_EQ(order_.size(), 53u);
}

// The thread of a connection must not be kept.
TEST_F(Work, IsPostedWithoutWaiting) {
  std::atomic<bool> goes_on = false;
  work_.post({"one"}, [&] { wait_until([&] { return goes_on.load(); }); });
  post("two", 't');
  EXPECT_EQ(work_.size(), 2u);
  goes_on = true;
  EXPECT_TRUE(wait_until([&] { return work_.size() == 0; }));
  EXPECT_EQ(order_, "t");
}

TEST(WorkOfClients, IsDoneBeforeItsEnd) {
  Turns turns(2);
  std::atomic<int> done = 0;
  {
    ClientWork work(turns);
    for (int i = 0; i < 100; ++i) work.post({i % 2 ? "a" : "b"}, [&] { ++done; });
  }
  EXPECT_EQ(done, 100);
  EXPECT_EQ(turns.waiting(), 0u);
}

}  // namespace
}  // namespace collided::server
