// The bytes that scenes hold on their backends.
#include "server/scenes/device_bytes.hpp"

#include <spdlog/fmt/fmt.h>

#include "server/errors.hpp"

namespace collided::server {

void DeviceBytes::take(uint64_t bytes) {
  const uint64_t before = held_.fetch_add(bytes), most = most_;
  try {
    if (before > most || bytes > most - before)
      throw LimitExceeded::quota(
          subject_, fmt::format("{} is {}, {} are held, and {} more are needed", limit_name_, most, before, bytes));
    if (whole_) whole_->take(bytes);
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
