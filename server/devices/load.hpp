#pragma once
// How busy a device is, of late. No gRPC here.

#include <cmath>

#include "server/ops/clock.hpp"

namespace collided::server {

/// Seconds of work a second. What was done kHalfLife ago counts half of what is done now. Not thread-safe.
class Load {
 public:
  static constexpr double kHalfLife = 3;  // seconds

  explicit Load(Clock::time_point now) : until_(now) {}

  /// So many seconds of work were done since the last call.
  void add(double work, Clock::time_point now) {
    total_ += work;
    const double seconds = seconds_between(until_, now);
    if (seconds <= 0) return;
    const double kept = std::exp2(-seconds / kHalfLife);
    load_ = load_ * kept + work / seconds * (1 - kept);
    until_ = now;
  }
  /// In hundredths, so that a device that has rested is idle.
  double now() const { return std::round(load_ * 100) / 100; }
  /// Seconds of all work so far.
  double total() const { return total_; }

 private:
  Clock::time_point until_;
  double load_ = 0, total_ = 0;
};

}  // namespace collided::server
