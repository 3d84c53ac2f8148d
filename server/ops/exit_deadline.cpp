// Ends a process that cannot stop by itself.
#include "server/ops/exit_deadline.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdlib>

#include "server/ops/log.hpp"

namespace collided::server {

ExitDeadline::ExitDeadline(double seconds, int code) : thread_([=, this] { wait(seconds, code); }) {}

ExitDeadline::~ExitDeadline() {
  {
    const std::lock_guard lock(mutex_);
    is_met_ = true;
  }
  met_.notify_all();
  thread_.join();
}

void ExitDeadline::wait(double seconds, int code) {
  std::unique_lock lock(mutex_);
  if (met_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return is_met_; })) return;
  spdlog::warn("stopped without waiting for clients that take no answers");
  flush_log();
  std::_Exit(code);
}

}  // namespace collided::server
