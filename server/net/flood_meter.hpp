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

  /// `max_unfinished`: bytes that may have come of messages that are not complete yet.
  FloodMeter(uint64_t max_unfinished, Time begin)
      : max_unfinished_(max_unfinished), looked_at_(begin), sent_at_(begin) {}

  /// A message of so many bytes has come.
  void received(uint64_t bytes);
  /// A message of so many bytes is about to be sent.
  void sent(uint64_t bytes);

  /// What the connection floods with, or "". To be called a few times a second, with its traffic. `is_known`: it has
  /// made a call whose caller is known.
  std::string_view look(const Traffic& traffic, Time now, bool is_known);

 private:
  bool is_unanswered(const Traffic& traffic, Time now);

  uint64_t max_unfinished_;
  Traffic traffic_;  // at the last look
  Time looked_at_;
  double taken_ = 0;           // bytes of messages that came since the last look
  double without_caller_ = 0;  // bytes, less those of time
  double without_message_ = 0, replies_ = 0;
  uint64_t read_at_sending_ = 0;  // bytes, by when something was last seen to be sent
  Time sent_at_;
};

}  // namespace collided::server
