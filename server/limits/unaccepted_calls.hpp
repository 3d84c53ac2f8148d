#pragma once
// Calls that have arrived and wait to be accepted. No gRPC here.

#include <cstddef>
#include <mutex>
#include <unordered_map>

namespace collided::server {

/// Thread-safe. gRPC keeps a call until it is accepted, even one that its client has reset, and accepting may take long
/// on a busy machine. A connection has no more calls open than it may have, so one with more that wait has reset some.
/// Many connections could hold gigabytes in this way: while there are too many in all, a connection may have one.
class UnacceptedCalls {
 public:
  /// Calls that may wait: of a connection, and in all before each connection may have only one.
  UnacceptedCalls(size_t max, size_t max_in_all) : max_(max), max_in_all_(max_in_all) {}

  /// A call has arrived. False if it must be refused; then it does not wait.
  bool arrive(const void* connection);
  /// A call that had arrived has been accepted.
  void accept(const void* connection);

  size_t waiting() const;
  /// True while there are too many in all.
  bool is_full() const { return waiting() >= max_in_all_; }

 private:
  const size_t max_, max_in_all_;
  mutable std::mutex mutex_;                            // guards what follows
  std::unordered_map<const void*, size_t> waiting_of_;  // none is 0
  size_t waiting_ = 0;
};

}  // namespace collided::server
