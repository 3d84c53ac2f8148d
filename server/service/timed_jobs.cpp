// One thread that runs jobs at their times.
#include "server/service/timed_jobs.hpp"

#include <utility>

namespace collided::server {

TimedJobs::~TimedJobs() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void TimedJobs::post(Clock::time_point when, Job job) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.emplace(when, std::move(job));
  }
  changed_.notify_one();
}

void TimedJobs::run() {
  std::unique_lock lock(mutex_);
  while (!is_over_) {
    if (jobs_.empty()) {
      changed_.wait(lock);
    } else if (const auto next = jobs_.begin()->first; next > Clock::now()) {
      changed_.wait_until(lock, next);
    } else {
      auto job = jobs_.extract(jobs_.begin());
      lock.unlock();
      job.mapped()();
      job = {};  // what it holds may post others when it ends
      lock.lock();
    }
  }
}

}  // namespace collided::server
