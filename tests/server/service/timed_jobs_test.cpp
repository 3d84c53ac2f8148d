// Jobs on one thread, in the order of their times.
#include "server/service/timed_jobs.hpp"

#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <vector>

namespace collided::server {
namespace {

TEST(TimedJobs, RunInTheOrderOfTheirTimesThenOfTheCalls) {
  TimedJobs jobs;
  std::promise<void> all_posted, done;
  jobs.post([&] { all_posted.get_future().wait(); });
  const auto now = Clock::now();
  std::vector<int> ran;
  jobs.post(now + std::chrono::milliseconds(3), [&] {
    ran.push_back(4);
    done.set_value();
  });
  jobs.post(now + std::chrono::milliseconds(1), [&] { ran.push_back(2); });
  jobs.post(now + std::chrono::milliseconds(1), [&] { ran.push_back(3); });
  jobs.post([&] { ran.push_back(1); });
  all_posted.set_value();
  done.get_future().wait();
  EXPECT_EQ(ran, (std::vector{1, 2, 3, 4}));
}

TEST(TimedJobs, AreNotRunBeforeTheirTime) {
  TimedJobs jobs;
  std::promise<Clock::time_point> ran;
  const auto when = Clock::now() + std::chrono::milliseconds(20);
  jobs.post(when, [&] { ran.set_value(Clock::now()); });
  EXPECT_GE(ran.get_future().get(), when);
}

TEST(TimedJobs, AreDroppedWithWhatTheyHoldAtTheEnd) {
  const auto held = std::make_shared<int>();
  {
    TimedJobs jobs;
    jobs.post(Clock::now() + std::chrono::hours(1), [held] {});
    EXPECT_EQ(held.use_count(), 2);
  }
  EXPECT_EQ(held.use_count(), 1);
}

TEST(TimedJobs, MayPostOthers) {
  TimedJobs jobs;
  std::promise<void> done;
  jobs.post([&] { jobs.post([&] { done.set_value(); }); });
  done.get_future().wait();
}

}  // namespace
}  // namespace collided::server
