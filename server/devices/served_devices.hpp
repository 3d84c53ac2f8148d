#pragma once
// The devices that scenes can live on: what the scenes of each share, and where a new scene goes. No gRPC here.

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gpu/detector.hpp"
#include "server/config/config.hpp"
#include "server/devices/device_bytes.hpp"
#include "server/devices/turns.hpp"
#include "server/ops/clock.hpp"

namespace collided::server {

/// What is known of a device when the daemon starts.
struct DeviceTerms {
  DeviceInfo info = {};
  int threads = 0;  ///< of the host, of a scene there; 0: as the scene's plan has it
  Turns::Options turns = {};
  uint64_t max_bytes = ~uint64_t{0};  ///< of its scenes
};

/// The devices of a configuration, ready for work.
struct DevicesAtStart {
  std::vector<DeviceTerms> terms = {};
  std::vector<UnusableDevice> unusable = {};  ///< not served; none where the configuration names those to be served
};

/// Loads the kernels of devices whose drivers have to compile them, which takes minutes. Throws ConfigError for a named
/// device that is not there, or that fails; others that fail are unusable. Throws std::runtime_error if the backend is
/// CUDA and no CUDA device is left.
DevicesAtStart devices_at_start(const Config& config, const Now& now);

/// What a new scene asks for.
struct DeviceWish {
  Backend backend = Backend::kCpu;
  std::optional<Device> device = {};         ///< of that backend; none: any
  std::vector<Device> shards = {};           ///< where each shard is to be, if it is sharded; `device` is the first
  uint64_t min_bytes = 0;                    ///< that it holds once it has had a frame
  std::shared_ptr<DeviceBytes> client = {};  ///< its client's quota; may be null
};

/// Where a scene goes.
struct Placement {
  Device device;
  int threads = 0;                     ///< as in DeviceTerms
  std::shared_ptr<DeviceBytes> quota;  ///< within the client's and the device's; the scene counts while it lives
  /// Of a sharded scene: each shard's, within its device's, which shards on one device share. Then `quota` is the
  /// client's.
  std::vector<std::shared_ptr<DeviceBytes>> shards = {};
};

/// A device at one moment.
struct DeviceState {
  DeviceInfo info;
  uint64_t max_bytes = 0, held_bytes = 0;
  uint64_t free_bytes = 0;  ///< for scenes, less what those that are there will need
  uint32_t scenes = 0;
  double load = 0, busy_seconds = 0;  ///< seconds of work a second, of late; of all work so far
  uint64_t waiting_frames = 0;        ///< for a turn
};

/// Thread-safe.
class ServedDevices {
 public:
  /// In the order of their ids; one or more.
  explicit ServedDevices(std::vector<DeviceTerms> terms, const Now& now = Clock::now);
  ServedDevices(DevicesAtStart devices, const Now& now);

  /// Of the devices that the wish allows and that have room, the one with the most free bytes for its load: free bytes
  /// divided by 1 + load; of equal ones the first. Throws LimitExceeded if there are several and none has room; where
  /// there is one, its quota decides.
  Placement place(const DeviceWish& wish);
  /// Where a scene would go now, whether there is room or not.
  const DeviceInfo& preferred(const DeviceWish& wish) const;
  /// Throws LimitExceeded if the scene would fit on no device even if there were no others.
  void check_could_hold(const DeviceWish& wish) const;

  Turns& turns(const Device& device) { return served(device).turns; }
  /// Turns of work on the host, one thread each: scenes are built, messages checked, calls answered.
  Turns& host_turns() { return host_turns_; }
  /// Limits of each device, from those of the daemon.
  void set_limits(const Limits& limits);
  std::vector<DeviceState> state() const;
  /// In order.
  std::vector<DeviceInfo> infos() const;
  /// Devices that are not served because they cannot be used.
  const std::vector<UnusableDevice>& unusable() const { return unusable_; }

 private:
  struct Served {
    explicit Served(DeviceTerms given);
    DeviceTerms terms;
    mutable Turns turns;
    std::shared_ptr<DeviceBytes> bytes;
    /// Of each scene its quota, and its DeviceWish::min_bytes.
    std::vector<std::pair<std::weak_ptr<DeviceBytes>, uint64_t>> scenes;  // guarded by mutex_
  };
  struct Candidate {
    const Served* served;
    uint64_t free;
    double score;
  };

  Served& served(const Device& device);
  const Served& served(const Device& device) const;
  // The caller holds the lock.
  Placement place_shards(const DeviceWish& wish);
  std::shared_ptr<DeviceBytes> add_scene(Served& served, uint64_t min_bytes,
                                         const std::shared_ptr<DeviceBytes>& client);
  std::vector<Candidate> candidates(const DeviceWish& wish) const;
  uint64_t free_bytes(const Served& served) const;

  std::deque<Served> served_;  // which never move
  const std::vector<UnusableDevice> unusable_;
  Turns host_turns_;
  bool has_several_gpus_ = false;
  mutable std::mutex mutex_;
};

}  // namespace collided::server
