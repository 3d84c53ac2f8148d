#pragma once
// The lease of a scene: the time that it outlives its last use. No gRPC here.

#include <chrono>
#include <mutex>
#include <utility>

#include "server/ops/clock.hpp"

namespace collided::server {

/// Safe from any thread: a mutex guards all that changes.
class SceneLease {
 public:
  SceneLease(double seconds, Now now) : seconds_(seconds), now_(std::move(now)) {}

  /// Suspends the lease until end_use().
  void begin_use() {
    const std::lock_guard lock(mutex_);
    ++uses_;
  }
  /// Restarts the lease, if this was the last use.
  void end_use() {
    const std::lock_guard lock(mutex_);
    --uses_;
    last_use_ = now_();
  }
  /// Returns true if the scene has been unused for longer than its lease.
  bool is_expired(Clock::time_point now) const {
    const std::lock_guard lock(mutex_);
    return uses_ == 0 && now - last_use_ > seconds_;
  }

 private:
  const std::chrono::duration<double> seconds_;
  const Now now_;
  mutable std::mutex mutex_;  // guards what follows
  unsigned uses_ = 0;
  Clock::time_point last_use_ = now_();
};

}  // namespace collided::server
