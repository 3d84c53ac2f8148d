// Calls that have arrived and wait to be accepted.
#include "server/limits/unaccepted_calls.hpp"

namespace collided::server {

bool UnacceptedCalls::arrive(const void* connection) {
  const std::lock_guard lock(mutex_);
  size_t& waiting = waiting_of_[connection];
  if (waiting >= max_) return false;
  ++waiting;
  return true;
}

void UnacceptedCalls::accept(const void* connection) {
  const std::lock_guard lock(mutex_);
  const auto found = waiting_of_.find(connection);
  if (found != waiting_of_.end() && --found->second == 0) waiting_of_.erase(found);
}

size_t UnacceptedCalls::waiting() const {
  const std::lock_guard lock(mutex_);
  size_t count = 0;
  for (const auto& [connection, waiting] : waiting_of_) count += waiting;
  return count;
}

}  // namespace collided::server
