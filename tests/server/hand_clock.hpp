#pragma once
// A clock that is advanced by hand. As on a machine that has just booted, it starts at 5 s.

#include <atomic>
#include <chrono>
#include <memory>

#include "server/ops/clock.hpp"

namespace collided::server {

class HandClock {
 public:
  Now now() const {
    return [time = time_] { return Clock::time_point(Clock::duration(time->load())); };
  }
  void move(std::chrono::duration<double> by) const {
    *time_ += std::chrono::duration_cast<Clock::duration>(by).count();
  }

 private:
  const std::shared_ptr<std::atomic<Clock::rep>> time_ =
      std::make_shared<std::atomic<Clock::rep>>(Clock::duration(std::chrono::seconds(5)).count());
};

}  // namespace collided::server
