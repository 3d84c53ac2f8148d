#pragma once
// What 'collidectl estimate' is asked to find room for.

#include <cstdint>
#include <optional>
#include <string>

namespace collided::cli {

struct Workload {
  uint32_t scenes = 1;
  std::optional<double> rate;              ///< frames a second of each scene
  std::optional<uint64_t> contacts;        ///< of a frame
  std::optional<double> step_ms;           ///< that a frame takes of a device
  std::optional<double> device_gigabytes;  ///< 10^9 bytes; else those of the daemon's device
  std::optional<double> network_gigabits;  ///< a second, each way, of a device's host
  std::string transport = "grpc";          ///< one of kTransports
  double utilisation = 0.7;                ///< of a device's time and of its network
  bool has_network() const { return transport == "grpc"; }
};

/// What a scene was found to cost by its frames.
struct Measured {
  int steps = 0;
  double engine_ms = 0;  ///< mean of a frame
  double bytes_out = 0;  ///< likewise
  double contacts = 0;   ///< likewise
  uint64_t device_bytes = 0;
};

/// What one scene costs.
struct SceneCost {
  uint64_t memory_bytes = 0;
  uint64_t frame_bytes = 0;         ///< to the daemon
  std::optional<double> bytes_out;  ///< of a frame, from it
  std::optional<double> step_ms;
};

}  // namespace collided::cli
