#pragma once
// What each client has in use of the limits that count over all its calls: open streams and frames a second.
// No gRPC here.

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/auth/client.hpp"

namespace collided::server {

class ClientUsage {
 public:
  explicit ClientUsage(size_t max_streams) : max_streams_(max_streams) {}

  /// Counts a stream for as long as the result lives. Throws LimitExceeded.
  std::shared_ptr<void> begin_stream(const Client& client);
  /// Counts a frame: a client may send as many as it may in a second at once, and that many a second on. Throws
  /// LimitExceeded with the time after which the frame would pass.
  void count_frame(const Client& client);
  size_t streams() const;
  void set_max_streams(size_t max_streams);

 private:
  using Clock = std::chrono::steady_clock;
  struct Entry {
    size_t streams = 0;
    double frames_left = 0;
    Clock::time_point filled{};
  };

  void end_stream(const std::string& name);

  mutable std::mutex mutex_;
  size_t max_streams_;
  size_t streams_ = 0;
  std::map<std::string, Entry> clients_;
};

}  // namespace collided::server
