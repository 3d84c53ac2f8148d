// Calls that have arrived and wait to be accepted.
#include "server/limits/unaccepted_calls.hpp"

namespace collided::server {

bool UnacceptedCalls::arrive(const void* connection) {
  const std::lock_guard lock(mutex_);
  const auto found = waiting_of_.find(connection);
  if (found != waiting_of_.end() && (found->second >= max_ || waiting_ >= max_in_all_)) return false;
  ++waiting_of_[connection];
  ++waiting_;
  return true;
}

void UnacceptedCalls::accept(const void* connection) {
  const std::lock_guard lock(mutex_);
  const auto found = waiting_of_.find(connection);
  if (found == waiting_of_.end()) return;
  --waiting_;
  if (--found->second == 0) waiting_of_.erase(found);
}

size_t UnacceptedCalls::waiting() const {
  const std::lock_guard lock(mutex_);
  return waiting_;
}

}  // namespace collided::server
