#pragma once
// The protocol of sd_notify(3), by libsystemd. Without it at build time, nobody is told anything.

#include <chrono>
#include <string>

namespace collided::server {

/// Sends `state` ("READY=1", "STATUS=text", one assignment per line) to the supervisor, if $NOTIFY_SOCKET names one.
void notify(const std::string& state);

/// Within which the supervisor wants to hear WATCHDOG=1, from $WATCHDOG_USEC; 0: never.
std::chrono::microseconds watchdog_timeout();

}  // namespace collided::server
