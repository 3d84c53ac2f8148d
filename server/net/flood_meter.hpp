#pragma once
// Whether a connection over TCP floods. gRPC bounds neither the frames of a connection nor a header that does not end,
// and goes on reading one that never pauses while others wait for the same thread.

#include <chrono>
#include <cstdint>
#include <string_view>

#include "server/net/sockets/peer.hpp"

namespace collided::server {

class FloodMeter {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit FloodMeter(Time begin) : looked_at_(begin), sent_at_(begin) {}

  /// A call.
  void began();
  void ended();
  /// A message of so many bytes has come.
  void received(uint64_t bytes);
  /// A message of so many bytes is about to be sent.
  void sent(uint64_t bytes);

  /// Before the traffic of a look is asked for: messages that come from now on may have bytes that are not yet in it,
  /// and count at the next look.
  void prepare_look();
  /// What the connection floods with, or "". To be called a few times a second, with its traffic. `is_known`: it has
  /// made a call whose caller is known.
  std::string_view look(const Traffic& traffic, Time now, bool is_known);
  /// Bytes by the last look that belong to no message that has come: to none, or to one that is not complete.
  uint64_t unfinished() const { return static_cast<uint64_t>(without_message_); }

 private:
  bool is_unanswered(const Traffic& traffic, Time now);

  Traffic traffic_;  // at the last look
  Time looked_at_;
  double taken_ = 0, due_ = 0;  // bytes of messages that came since the last look was prepared, and before
  double without_caller_ = 0;  // bytes, less those of time
  double without_message_ = 0, replies_ = 0;
  uint64_t read_at_sending_ = 0;  // bytes, by when something was last seen to be sent
  uint64_t calls_ = 0, most_calls_ = 0;  // that are open, and at most since then
  Time sent_at_;
};

}  // namespace collided::server
