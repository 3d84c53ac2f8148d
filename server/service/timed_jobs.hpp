#pragma once
// One thread that runs jobs at their times.

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

#include "server/ops/clock.hpp"

namespace collided::server {

/// Thread-safe.
class TimedJobs {
 public:
  using Job = std::function<void()>;  ///< must not throw

  TimedJobs() : thread_([this] { run(); }) {}
  /// Drops the jobs that have not started.
  ~TimedJobs();
  TimedJobs(const TimedJobs&) = delete;
  TimedJobs& operator=(const TimedJobs&) = delete;

  /// Jobs of the same time run in the order of the calls.
  void post(Clock::time_point when, Job job);
  void post(Job job) { post(Clock::time_point::min(), std::move(job)); }

 private:
  void run();

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::multimap<Clock::time_point, Job> jobs_;
  bool is_over_ = false;
  std::thread thread_;  // last, so that it starts when the others are there
};

}  // namespace collided::server
