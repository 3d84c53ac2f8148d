#pragma once
// Log lines that callers cause are written at a bounded rate; the metrics count all.

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace collided::server {

/// Which of many events of a kind get a line: the first few of each second. Thread-safe. There must be few kinds.
class LogRate {
 public:
  using Clock = std::chrono::steady_clock;

  explicit LogRate(uint64_t most_a_second) : most_(most_a_second) {}
  /// How many of the kind got none since the last line; nothing if this one gets none, too.
  std::optional<uint64_t> admit(const std::string& kind, Clock::time_point now = Clock::now());

 private:
  struct Second {
    Clock::time_point begin;
    uint64_t events = 0, left_out = 0;
  };

  const uint64_t most_;
  std::mutex mutex_;
  std::map<std::string, Second> seconds_;  // guarded by mutex_; of each kind
};

/// Whether a refusal of `what` (a method, or "frame") with this code gets a line. Tells first, in a line of its own,
/// how many before it got none.
bool admit_refusal(std::string_view what, std::string_view code);

}  // namespace collided::server
