#pragma once
// The clock of leases, idle limits, rates and turns. Its epoch is arbitrary: it may be the boot time, seconds
// ago.

#include <chrono>
#include <functional>

namespace collided::server {

using Clock = std::chrono::steady_clock;

/// Returns the time; thread-safe. Tests substitute a clock that they advance themselves.
using Now = std::function<Clock::time_point()>;

inline double seconds_between(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double>(end - begin).count();
}

inline double milliseconds_since(Clock::time_point begin) { return 1000 * seconds_between(begin, Clock::now()); }

}  // namespace collided::server
