// Which devices of this machine the daemon serves.
#include "server/devices/chosen_devices.hpp"

#include <algorithm>
#include <string_view>
#include <thread>

namespace collided::server {
namespace {

int count_cpus(const Config& config) {
  return static_cast<int>(std::ranges::count_if(named_devices(config),
                                                [](const Device& device) { return device.backend == Backend::kCpu; }));
}

std::string without_field(std::string_view what) {
  constexpr std::string_view kField = "device: ";
  return std::string(what.starts_with(kField) ? what.substr(kField.size()) : what);
}

// The CPU has whatever ordinals are named.
DeviceInfo info_of(const Device& device, const std::vector<DeviceInfo>& there) try {
  check_device(device);
  const auto found = std::ranges::find_if(there, [&](const DeviceInfo& info) {
    return device.backend == Backend::kCpu ? info.device.backend == Backend::kCpu : info.device == device;
  });
  if (found == there.end()) throw ConfigError("--device is " + to_string(device) + ", which cannot be used");
  DeviceInfo info = *found;
  info.device = device;
  return info;
} catch (const InvalidInput& error) {
  throw ConfigError(std::string("--") + error.what());
} catch (const DeviceError& error) {
  throw ConfigError("--device is " + to_string(device) + ", which cannot be used: " + without_field(error.what()));
}

}  // namespace

std::vector<Device> named_devices(const Config& config) {
  std::vector<Device> devices;
  for (const std::string& name : config.devices)
    if (const auto device = parse_device(name)) devices.push_back(*device);
  return devices;
}

std::vector<DeviceInfo> chosen_devices(const Config& config) {
  const std::vector<DeviceInfo> there = list_devices(threads_of_scene(config, Backend::kCpu));
  std::vector<DeviceInfo> chosen = config.devices.empty() ? there : std::vector<DeviceInfo>();
  for (const Device& device : named_devices(config)) chosen.push_back(info_of(device, there));
  std::ranges::sort(chosen, {}, &DeviceInfo::device);
  return chosen;
}

int threads_of_scene(const Config& config, Backend backend) {
  const int cpus = count_cpus(config);
  if (config.threads > 0 || backend == Backend::kCuda || cpus < 2) return config.threads;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / cpus);
}

}  // namespace collided::server
