#pragma once
// gRPC deadlines on the monotonic clock: the wall clock may be set while a call waits.

#include <grpc/support/time.h>

#include <algorithm>
#include <chrono>

namespace collided::client {

inline gpr_timespec no_deadline() { return gpr_inf_future(GPR_CLOCK_MONOTONIC); }

/// `time` from now: now for negative times, never for 100 years or more, which overflow some clocks.
template <class Rep, class Period>
gpr_timespec deadline_in(std::chrono::duration<Rep, Period> time) {
  constexpr std::chrono::hours kMax(24 * 365 * 100);
  if (time >= kMax) return no_deadline();
  const std::chrono::nanoseconds left = std::max(time, time.zero());
  return gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC), gpr_time_from_nanos(left.count(), GPR_TIMESPAN));
}

}  // namespace collided::client
