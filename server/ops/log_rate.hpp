#pragma once
// Log lines that callers cause are rate-limited; the metrics count everything.

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace collided::server {

/// Decides which of many events of a kind are logged: the first few of each second. Thread-safe. There must be few
/// kinds.
class LogRate {
 public:
  using Clock = std::chrono::steady_clock;

  explicit LogRate(uint64_t max_per_second) : max_(max_per_second) {}
  /// Number of events of the kind left out since the last line; nullopt if this one is left out, too.
  std::optional<uint64_t> admit(const std::string& kind, Clock::time_point now = Clock::now());

 private:
  struct Second {
    Clock::time_point begin;
    uint64_t events = 0, left_out = 0;
  };

  const uint64_t max_;
  std::mutex mutex_;
  std::map<std::string, Second> seconds_;  // guarded by mutex_; of each kind
};

/// Whether to log a refusal of `what` (a method, or "frame") with this code. First logs, in a separate line, how many
/// were left out before it.
bool admit_refusal(std::string_view what, std::string_view code);

}  // namespace collided::server
