#pragma once
// Which devices of this machine the daemon serves. No gRPC here.

#include <vector>

#include "gpu/detector.hpp"
#include "server/config/config.hpp"

namespace collided::server {

/// Those that --device names, in the order of the names; may be empty.
std::vector<Device> named_devices(const Config& config);

/// Those that --device names, else every CUDA device and the CPU; in the order of their ids. Throws ConfigError for one
/// that is not there.
std::vector<DeviceInfo> chosen_devices(const Config& config);

/// Of the CPU threads of a scene, where several devices of the CPU share the cores; 0: all cores.
int threads_of_scene(const Config& config, Backend backend);

}  // namespace collided::server
