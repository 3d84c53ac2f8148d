#pragma once
// The time that leases, idle limits, rates and turns are counted in. Its epoch means nothing: it may be the machine's
// start, seconds ago.

#include <chrono>
#include <functional>

namespace collided::server {

using Clock = std::chrono::steady_clock;

/// Tells the time, from any thread. A test has its own, which it moves by hand.
using Now = std::function<Clock::time_point()>;

inline double seconds_between(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double>(end - begin).count();
}

}  // namespace collided::server
