// The bytes that scenes hold.
#include "server/devices/device_bytes.hpp"

#include <spdlog/fmt/fmt.h>

#include <limits>

#include "server/errors.hpp"

namespace collided::server {
namespace {

constexpr const char* kSceneLimit = "spec.memory_budget_bytes";
constexpr uint64_t kNoLimit = std::numeric_limits<uint64_t>::max();

}  // namespace

std::shared_ptr<DeviceBytes> DeviceBytes::of_scene(uint64_t budget, std::shared_ptr<DeviceBytes> parent) {
  return std::make_shared<DeviceBytes>("scene", kSceneLimit, budget > 0 ? budget : kNoLimit, std::move(parent));
}

std::shared_ptr<DeviceBytes> DeviceBytes::within(std::shared_ptr<DeviceBytes> client,
                                                 std::shared_ptr<DeviceBytes> device) {
  auto bytes = std::make_shared<DeviceBytes>("scene", kSceneLimit, kNoLimit, std::move(client));
  bytes->parents_[1] = std::move(device);
  return bytes;
}

// A refused request is never counted, not even briefly: others would be refused because of it.
void DeviceBytes::take(uint64_t bytes) {
  for (uint64_t before = held_;;) {
    const uint64_t max = max_;
    if (before > max || bytes > max - before)
      refuse(fmt::format("{} bytes; {} {} of them, and {} more are needed", max, holder(), before, bytes));
    if (held_.compare_exchange_weak(before, before + bytes)) break;
  }
  try {
    take_of_parents(bytes);
  } catch (...) {
    held_ -= bytes;
    throw;
  }
}

void DeviceBytes::take_of_parents(uint64_t bytes) {
  const auto& [first, second] = parents_;
  if (first) first->take(bytes);
  if (second) try {
      second->take(bytes);
    } catch (...) {
      if (first) first->give_back(bytes);
      throw;
    }
}

void DeviceBytes::give_back(uint64_t bytes) noexcept {
  held_ -= bytes;
  for (const auto& parent : parents_)
    if (parent) parent->give_back(bytes);
}

void DeviceBytes::check_could_hold(uint64_t bytes, const std::string& what) const {
  const uint64_t max = max_;
  if (bytes > max) refuse(fmt::format("{} bytes, but {} need at least {}", max, what, bytes));
  for (const auto& parent : parents_)
    if (parent) parent->check_could_hold(bytes, what);
}

// A scene's budget is a field of its request.
void DeviceBytes::refuse(const std::string& why) const {
  const std::string message = limit_name_ + " is " + why;
  if (limit_name_ == kSceneLimit) throw LimitExceeded(kSceneLimit, message);
  throw LimitExceeded::quota(subject_, message);
}

std::string DeviceBytes::holder() const {
  if (subject_ == "daemon") return "all scenes of this daemon hold";
  if (limit_name_ == kSceneLimit) return "the scene holds";
  if (subject_.starts_with("device:")) return "all scenes there hold";
  return "the scenes of " + subject_ + " hold";
}

}  // namespace collided::server
