#pragma once
// gRPC's deadlines, told by the monotonic clock: the time of day may be set while a call waits.

#include <grpc/support/time.h>

#include <algorithm>
#include <chrono>

namespace collided::client {

inline gpr_timespec no_deadline() { return gpr_inf_future(GPR_CLOCK_MONOTONIC); }

/// So long from now: at once for negative times, never for 100 years and more, which clocks may not hold.
template <class Rep, class Period>
gpr_timespec deadline_in(std::chrono::duration<Rep, Period> time) {
  constexpr std::chrono::hours kLongest(24 * 365 * 100);
  if (time >= kLongest) return no_deadline();
  const std::chrono::nanoseconds left = std::max(time, time.zero());
  return gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC), gpr_time_from_nanos(left.count(), GPR_TIMESPAN));
}

}  // namespace collided::client
