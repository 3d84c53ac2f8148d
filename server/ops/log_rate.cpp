// Rate limits for log lines that callers cause.
#include "server/ops/log_rate.hpp"

#include <utility>

#include "server/ops/log.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kRefusalsPerSecond = 10;  // of one method and code

}  // namespace

std::optional<uint64_t> LogRate::admit(const std::string& kind, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  Second& second = seconds_.try_emplace(kind, Second{now}).first->second;
  if (now - second.begin >= std::chrono::seconds(1)) second = {now, 0, second.left_out};
  if (++second.events <= max_) return std::exchange(second.left_out, 0);
  ++second.left_out;
  return {};
}

bool admit_refusal(std::string_view what, std::string_view code) {
  static LogRate rate(kRefusalsPerSecond);
  const auto left_out = rate.admit(std::string(what).append(1, ' ').append(code));
  if (left_out.value_or(0) > 0)
    log_event(spdlog::level::info, "refusals left out of the log",
              {{"method", what}, {"code", code}, {"count", *left_out}});
  return left_out.has_value();
}

}  // namespace collided::server
