#pragma once
// Calls that have arrived and wait to be accepted. No gRPC here.

#include <cstddef>
#include <mutex>
#include <unordered_map>

namespace collided::server {

/// Thread-safe. gRPC keeps a call until it is accepted, even one that its client has reset, and accepting may take long
/// on a busy machine. A connection has no more calls open than it may have, so one with more that wait has reset some.
class UnacceptedCalls {
 public:
  /// `max`: calls of a connection that may wait.
  explicit UnacceptedCalls(size_t max) : max_(max) {}

  /// A call has arrived. False if it must be refused; then it does not wait.
  bool arrive(const void* connection);
  /// A call that had arrived has been accepted.
  void accept(const void* connection);

  size_t waiting() const;

 private:
  const size_t max_;
  mutable std::mutex mutex_;                            // guards what follows
  std::unordered_map<const void*, size_t> waiting_of_;  // none is 0
};

}  // namespace collided::server
