#pragma once
// How many scenes a device has room for, and how many devices a workload needs.

#include <optional>
#include <string>
#include <vector>

#include "client/measure/capacity/workload.hpp"

namespace collided::cli {

/// Of a device, what scenes share.
struct Resource {
  std::string name;                 ///< "memory", "time" or "network"
  uint64_t scenes_per_device = 0;   ///< 0: one scene alone needs more
  std::optional<uint64_t> devices;  ///< none: no number of them is enough
};

struct Plan {
  std::vector<Resource> resources;  ///< those that are known; memory is
  /// The one that leaves the fewest scenes to a device, the first if several do.
  const Resource& binding() const;
};

/// Bytes of a device that scenes may hold, of so many in all: what the daemon's max-device-mb is by default at most.
uint64_t usable_bytes(double device_bytes);

/// Gigabits a second, each way, of all frames of one scene. Nothing is known without a rate.
struct Traffic {
  std::optional<double> in, out;
};
Traffic traffic_of(const Workload& workload, const SceneCost& scene);

/// A scene is on one device. Time is known with a rate and a step's time, the network with a rate and its speed.
Plan plan_of(const Workload& workload, const SceneCost& scene, uint64_t usable_bytes);

}  // namespace collided::cli
