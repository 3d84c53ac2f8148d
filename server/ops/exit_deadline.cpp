// The end of a process that cannot stop by itself.
#include "server/ops/exit_deadline.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdlib>
#include <future>
#include <memory>

namespace collided::server {
namespace {

// Whoever takes the log may have stopped to: it gets a moment.
void say(const char* line) {
  constexpr auto kMoment = std::chrono::milliseconds(500);
  const auto said = std::make_shared<std::promise<void>>();
  std::thread([=] {
    spdlog::warn("{}", line);
    spdlog::default_logger()->flush();
    said->set_value();
  }).detach();
  said->get_future().wait_for(kMoment);
}

}  // namespace

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
  say("stopped without the clients that take no answer");
  std::_Exit(code);
}

}  // namespace collided::server
