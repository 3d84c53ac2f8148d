// The bytes that scenes hold on their backends.
#include "server/scenes/device_bytes.hpp"

#include <spdlog/fmt/fmt.h>

#include "server/errors.hpp"

namespace collided::server {

// What is refused is never counted, not even for a moment: it would stand in the way of others.
void DeviceBytes::take(uint64_t bytes) {
  for (uint64_t before = held_;;) {
    const uint64_t most = most_;
    if (before > most || bytes > most - before)
      throw LimitExceeded::quota(
          subject_, fmt::format("{} is {}, {} are held, and {} more are needed", limit_name_, most, before, bytes));
    if (held_.compare_exchange_weak(before, before + bytes)) break;
  }
  if (!whole_) return;
  try {
    whole_->take(bytes);
  } catch (...) {
    held_ -= bytes;
    throw;
  }
}

void DeviceBytes::give_back(uint64_t bytes) noexcept {
  held_ -= bytes;
  if (whole_) whole_->give_back(bytes);
}

}  // namespace collided::server
