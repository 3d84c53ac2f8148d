#pragma once
// Memory for the messages of all calls, taken before a message is parsed and held until its call ends. No gRPC here.

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/auth/client.hpp"

namespace collided::server {

/// Thread-safe. Outlives the shares that it gives.
class DecodeBudget {
 public:
  explicit DecodeBudget(uint64_t max_bytes) : max_(max_bytes) {}

  /// Taken for as long as the result lives. One client may take half of all. Throws LimitExceeded with the time after
  /// which to try again.
  std::shared_ptr<void> take(const Client& client, uint64_t bytes);

 private:
  struct Share;

  void reserve(const std::string& name, uint64_t bytes);
  void give_back(const std::string& name, uint64_t bytes);

  const uint64_t max_;
  std::mutex mutex_;
  uint64_t taken_ = 0;                       // guarded by mutex_
  std::map<std::string, uint64_t> clients_;  // guarded by mutex_; of clients that have a share
};

}  // namespace collided::server
