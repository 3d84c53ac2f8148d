#pragma once
// Packets to be sent over a non-blocking socket. Not thread-safe.

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "server/transport/local/packets.hpp"

namespace collided::server {

class Outbox {
 public:
  using Clock = std::chrono::steady_clock;

  /// Sends at once if possible; otherwise keeps the packet, and with it `held`, its share of a quota.
  void send(int socket, std::string packet, std::shared_ptr<const void> held = {});
  /// Sends kept packets, until the other end takes no more.
  void flush(int socket);

  bool empty() const { return kept_.empty(); }
  uint64_t bytes() const { return bytes_; }
  /// When the other end last took a packet, or the first one was kept; valid while packets are kept.
  Clock::time_point stalled_since() const { return stalled_since_; }
  /// Whether the other end is gone; kept packets are dropped then.
  bool is_gone() const { return is_gone_; }
  /// Whether packets are kept because the system was short of memory: flush() then has to be called after a while.
  bool is_short() const { return is_short_ && !kept_.empty(); }
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
  bool is_gone_ = false, is_short_ = false;
};

}  // namespace collided::server
