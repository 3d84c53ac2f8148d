#pragma once
// Memory for the messages of all calls, from before they are parsed until their calls end. No gRPC here.

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/auth/client.hpp"

namespace collided::server {

/// Thread-safe. Outlives what it gives.
class DecodeBudget {
 public:
  /// Bytes of `max_decode_bytes`, but never less than the largest messages of two clients take.
  explicit DecodeBudget(const Limits& limits);

  /// Taken for as long as the result lives. One client may take half of all. Throws LimitExceeded with the time after
  /// which a new try is worth it.
  std::shared_ptr<void> take(const Client& client, uint64_t bytes);
  uint64_t most() const { return most_; }

 private:
  struct Share;

  void reserve(const std::string& name, uint64_t bytes);
  void give_back(const std::string& name, uint64_t bytes);

  const uint64_t most_;
  std::mutex mutex_;
  uint64_t taken_ = 0;                       // guarded by mutex_
  std::map<std::string, uint64_t> clients_;  // guarded by mutex_; of those that have taken some
};

}  // namespace collided::server
