// Whether a connection over TCP floods.
#include "server/net/flood_meter.hpp"

#include <algorithm>
#include <utility>

namespace collided::server {
namespace {

// Without a call: a call's headers, and what may come before they are looked at, are a tenth of it at most.
constexpr double kMaxWithoutCaller = 1 << 20, kWithoutCallerPerSecond = 64 << 10;

// Bytes that are read, and for how long, while nothing is sent. Messages need windows (RFC 9113, section 5.2): gRPC
// sends a new one when half of one is used up. A connection's grows to what arrives within a ping's way there and back,
// and by a megabyte for each open call; of one call, 23 MB were seen to be read between two, at 2 GB/s.
constexpr uint64_t kMaxUnanswered = 32 << 20, kUnansweredOfCall = 4 << 20;
constexpr auto kTimeUnanswered = std::chrono::milliseconds(300);

// What is sent beside messages: headers and trailers of calls, frames' heads, TLS records, windows, answers to pings.
constexpr double kMaxReplies = 4 << 20, kRepliesPerSecond = 64 << 10, kRepliesOfMessage = 4 << 10;
constexpr double kRepliesOfByteSent = 1.0 / 32, kRepliesOfByteReceived = 1.0 / 64;

// What comes beside messages: headers of calls, frames' heads, messages whose calls are cancelled before they end.
constexpr double kWithoutMessagePerSecond = 4 << 20, kHeadersOfMessage = 16 << 10;

double since(uint64_t before, uint64_t now) { return static_cast<double>(std::max(now, before) - before); }

// Time wears off what is too much; what is left over stays for what follows.
double worn(double value, double by) { return value > 0 ? std::max(0.0, value - by) : value; }

}  // namespace

void FloodMeter::began() { most_calls_ = std::max(most_calls_, ++calls_); }

void FloodMeter::ended() { calls_ -= calls_ > 0; }  // 0: it was of an earlier connection from the same port

void FloodMeter::received(uint64_t bytes) {
  taken_ += static_cast<double>(bytes) + kHeadersOfMessage;
  replies_ -= static_cast<double>(bytes) * kRepliesOfByteReceived + kRepliesOfMessage;
}

void FloodMeter::sent(uint64_t bytes) {
  replies_ -= static_cast<double>(bytes) * (1 + kRepliesOfByteSent) + kRepliesOfMessage;
}

void FloodMeter::prepare_look() { due_ += std::exchange(taken_, 0); }

std::string_view FloodMeter::look(const Traffic& traffic, Time now, bool is_known) {
  const double seconds = std::chrono::duration<double>(now - looked_at_).count();
  without_caller_ =
      worn(without_caller_ + since(traffic_.received, traffic.received), kWithoutCallerPerSecond * seconds);
  // Bytes are read before their message has come: nothing is left over but headers that were not needed.
  without_message_ = std::max(0.0, without_message_ + since(traffic_.read, traffic.read) - std::exchange(due_, 0));
  without_message_ = worn(without_message_, kWithoutMessagePerSecond * seconds);
  replies_ = worn(replies_ + since(traffic_.acknowledged, traffic.acknowledged), kRepliesPerSecond * seconds);
  const bool unanswered = is_unanswered(traffic, now);
  traffic_ = traffic;
  looked_at_ = now;
  if (!is_known && without_caller_ > kMaxWithoutCaller) return "bytes without a call";
  if (unanswered) return "frames that need no window";
  if (replies_ > kMaxReplies) return "frames that are answered";
  return "";
}

bool FloodMeter::is_unanswered(const Traffic& traffic, Time now) {
  if (traffic.sent != traffic_.sent) {
    read_at_sending_ = traffic.read;
    sent_at_ = now;
    most_calls_ = calls_;
  }
  const uint64_t max = kMaxUnanswered + most_calls_ * kUnansweredOfCall;
  return traffic.read > read_at_sending_ + max && now > sent_at_ + kTimeUnanswered;
}

}  // namespace collided::server
