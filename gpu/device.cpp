#include "gpu/device.hpp"

#include <charconv>

namespace collided {

std::string to_string(const Device& device) {
  return (device.backend == Backend::kCuda ? "cuda:" : "cpu:") + std::to_string(device.ordinal);
}

std::string to_string(const UnusableDevice& unusable) {
  if (!unusable.device) return unusable.reason;
  const std::string name = unusable.name.empty() ? "" : " (" + unusable.name + ")";
  return to_string(*unusable.device) + name + ": " + unusable.reason;
}

std::optional<Device> parse_device(std::string_view text) {
  const size_t colon = text.find(':');
  const std::string_view backend = text.substr(0, colon);
  if (backend != "cpu" && backend != "cuda") return {};
  Device device{backend == "cuda" ? Backend::kCuda : Backend::kCpu, 0};
  if (colon == std::string_view::npos) return device;
  const std::string_view ordinal = text.substr(colon + 1);
  const auto [end, error] = std::from_chars(ordinal.data(), ordinal.data() + ordinal.size(), device.ordinal);
  if (error != std::errc() || end != ordinal.data() + ordinal.size() || device.ordinal < 0) return {};
  return device;
}

}  // namespace collided
