// Built without libsystemd.
#include "server/ops/supervisor/notify.hpp"

namespace collided::server {

void notify(const std::string&) {}

std::chrono::microseconds watchdog_timeout() { return {}; }

}  // namespace collided::server
