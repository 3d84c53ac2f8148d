#pragma once
// gRPC's deadlines, told by the monotonic clock: the time of day may be set while a call waits.

#include <grpc/support/time.h>

#include <chrono>

namespace collided::client {

/// So long from now.
inline gpr_timespec deadline_in(std::chrono::nanoseconds time) {
  return gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC), gpr_time_from_nanos(time.count(), GPR_TIMESPAN));
}

inline gpr_timespec no_deadline() { return gpr_inf_future(GPR_CLOCK_MONOTONIC); }

}  // namespace collided::client
