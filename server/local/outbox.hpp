#pragma once
// Packets on their way out of a socket that does not block. Not thread-safe.

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "server/local/packets.hpp"

namespace collided::server {

class Outbox {
 public:
  using Clock = std::chrono::steady_clock;

  /// Sends at once if it can, else keeps the packet, and what it `held` of a limit.
  void send(int socket, std::string packet, std::shared_ptr<const void> held = {});
  /// Sends what was kept, as far as the other end takes it.
  void flush(int socket);

  bool empty() const { return kept_.empty(); }
  uint64_t bytes() const { return bytes_; }
  /// Since when the other end has taken nothing. Of use if there is something kept.
  Clock::time_point stalled_since() const { return stalled_since_; }
  /// Nobody is at the other end any more; what was kept is dropped.
  bool is_gone() const { return is_gone_; }
  void drop();

 private:
  struct Kept {
    std::string packet;
    std::shared_ptr<const void> held;
  };

  void keep(std::string packet, std::shared_ptr<const void> held);

  std::deque<Kept> kept_;
  uint64_t bytes_ = 0;
  Clock::time_point stalled_since_{};
  bool is_gone_ = false;
};

}  // namespace collided::server
