#pragma once
// Memory for the messages of all calls, reserved before a message is parsed and held until its call ends. No gRPC here.

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/auth/client.hpp"

namespace collided::server {

/// Thread-safe. Must outlive its shares.
class DecodeBudget {
 public:
  explicit DecodeBudget(uint64_t max_bytes) : max_(max_bytes) {}

  /// Reserves `bytes` while the result lives. One client may hold half of the budget. Throws LimitExceeded with the
  /// time to wait before a retry.
  std::shared_ptr<void> take(const Client& client, uint64_t bytes);

 private:
  struct Share;

  void reserve(const std::string& name, uint64_t bytes);
  void give_back(const std::string& name, uint64_t bytes);

  const uint64_t max_;
  std::mutex mutex_;
  uint64_t taken_ = 0;                       // guarded by mutex_
  std::map<std::string, uint64_t> clients_;  // guarded by mutex_; only clients with a share
};

}  // namespace collided::server
