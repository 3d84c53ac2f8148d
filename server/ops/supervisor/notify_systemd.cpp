// The protocol of sd_notify(3), by libsystemd.
#include <systemd/sd-daemon.h>

#include "server/ops/supervisor/notify.hpp"

namespace collided::server {

// A supervisor that cannot be reached is no reason to stop serving.
void notify(const std::string& state) { sd_notify(0, state.c_str()); }

std::chrono::microseconds watchdog_timeout() {
  uint64_t timeout = 0;
  return std::chrono::microseconds(sd_watchdog_enabled(0, &timeout) > 0 ? timeout : 0);
}

}  // namespace collided::server
