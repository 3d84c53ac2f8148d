// What the daemon tells the service manager that started it.
#include "server/ops/supervisor/supervisor.hpp"

#include <time.h>

#include <algorithm>
#include <cstdint>

#include "server/ops/supervisor/notify.hpp"

namespace collided::server {
namespace {

constexpr int64_t kMicroseconds = 1'000'000;

std::string join(const std::vector<std::string>& words) {
  std::string joined;
  for (const auto& word : words) joined += (joined.empty() ? "" : ", ") + word;
  return joined;
}

/// A status is one line: what follows a newline would be another message.
std::string status_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return "\nSTATUS=" + text;
}

std::string extension(double seconds) {
  return "EXTEND_TIMEOUT_USEC=" + std::to_string(static_cast<int64_t>(seconds * kMicroseconds));
}

int64_t monotonic_microseconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kMicroseconds + now.tv_nsec / 1000;
}

}  // namespace

Supervisor::Supervisor() : timeout_(watchdog_timeout()) {}

void Supervisor::starting(double seconds, const std::string& status) {
  notify(extension(seconds) + status_line(status));
}

void Supervisor::ready(const std::vector<std::string>& addresses) {
  serves_ = "serves on " + join(addresses);
  notify("READY=1" + status_line(serves_));
}

void Supervisor::reloading() {
  notify("RELOADING=1\nMONOTONIC_USEC=" + std::to_string(monotonic_microseconds()) +
         status_line("reads its configuration again"));
}

void Supervisor::reloaded(const std::string& problem) {
  notify("READY=1" + status_line(problem.empty() ? serves_ : serves_ + "; configuration not read again: " + problem));
}

void Supervisor::stopping(double seconds) { notify("STOPPING=1\n" + extension(seconds) + status_line("stops")); }

// A quarter, so that one late call, or a machine that is busy, is not taken for a stuck daemon.
std::chrono::microseconds Supervisor::alive_interval() const {
  using namespace std::chrono_literals;
  return watches() ? std::max<std::chrono::microseconds>(timeout_ / 4, 1ms) : 1h;
}

void Supervisor::alive() {
  const auto now = std::chrono::steady_clock::now();
  if (!watches() || now < next_) return;
  next_ = now + alive_interval() / 2;
  notify("WATCHDOG=1");
}

}  // namespace collided::server
