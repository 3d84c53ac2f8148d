// Whether the daemon serves, and why not.
#include "server/ops/lifecycle.hpp"

namespace collided::server {

std::string Lifecycle::Status::text() const {
  switch (state) {
    case State::kStarting:
      return "starting";
    case State::kServing:
      return obstacle.empty() ? "ready" : "not ready: " + obstacle;
    case State::kDraining:
      return "draining";
    case State::kFailed:
      break;
  }
  return "failed: " + reason;
}

void Lifecycle::serve() {
  std::lock_guard lock(mutex_);
  if (status_.state == State::kStarting) status_.state = State::kServing;
}

void Lifecycle::drain() {
  std::lock_guard lock(mutex_);
  if (status_.state != State::kFailed) status_.state = State::kDraining;
}

void Lifecycle::fail(const std::string& reason) {
  {
    std::lock_guard lock(mutex_);
    if (status_.state == State::kFailed) return;
    status_ = {State::kFailed, reason, {}};
  }
  wake_();
}

void Lifecycle::set_obstacle(const std::string& obstacle) {
  std::lock_guard lock(mutex_);
  status_.obstacle = obstacle;
}

Lifecycle::Status Lifecycle::status() const {
  std::lock_guard lock(mutex_);
  return status_;
}

}  // namespace collided::server
