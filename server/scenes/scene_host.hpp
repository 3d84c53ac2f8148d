#pragma once
// All scenes of the daemon: limits, leases, idle streams, fair turns. No gRPC here.

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "server/config/config.hpp"
#include "server/devices/served_devices.hpp"
#include "server/limits/client_usage.hpp"
#include "server/ops/freed_memory.hpp"
#include "server/scenes/scene_store.hpp"
#include "server/scenes/upload.hpp"

namespace collided::server {

/// What the daemon holds at one moment.
struct HostTotals {
  uint64_t scenes = 0, streams = 0, watchers = 0, device_bytes = 0, waiting_frames = 0;
  std::vector<DeviceState> devices = {};
};

class SceneHost {
 public:
  /// `observer` outlives the host. `now` is the clock of leases, idle streams, rates and turns. Throws ConfigError for
  /// devices that cannot be used.
  SceneHost(const Config& config, SceneObserver& observer, const Now& now = Clock::now);
  ~SceneHost();
  SceneHost(const SceneHost&) = delete;
  SceneHost& operator=(const SceneHost&) = delete;

  SceneStore& scenes() { return scenes_; }
  /// Within the owner's limits. Throws Stopping, LimitExceeded, AlreadyExists.
  SceneStore::Added add_scene(const Client& owner, SceneRequest request);
  /// Whether the owner could add such a scene if there were no others. Throws Stopping, LimitExceeded.
  void check_could_add(const Client& owner, const ScenePlan& plan);
  ClientUsage& usage() { return usage_; }
  /// Counts a stream of frames while the result lives: one that takes over with this token in the place of the one that
  /// it ends. Throws LimitExceeded.
  std::shared_ptr<void> begin_stream(const Client& client, const Scene& scene, const std::string& resume_token) {
    return usage_.begin_stream(client, scene.record().would_take_over(resume_token));
  }
  const ServedDevices& devices() const { return devices_; }
  Turns& host_turns() { return devices_.host_turns(); }
  OpenUploads& uploads() { return uploads_; }
  /// Ends uploads that have been silent for too long or whose scenes are gone.
  void end_stale_uploads();
  Limits limits() const;
  /// Applies to new requests; existing scenes and streams are unaffected.
  void set_limits(const Limits& limits);

  /// Throws Stopping after announce_stop().
  void check_serving() const;
  /// Refuses new scenes and streams, and announces the stop to every open stream.
  void announce_stop(double seconds);
  /// For each stream, once its scene has it: announces a stop that did not find it yet. Throws Stopping after
  /// end_streams().
  void tell_of_stop(SceneStream& stream) const;
  /// Ends all streams and watches with Stopping.
  void end_streams();
  HostTotals totals() const;
  /// Ends whatever has been idle for too long. The host's own thread calls it four times a second.
  void watch_once();

 private:
  void watch();
  void end_idle_streams() const;
  void end_unread_watches() const;

  const Now now_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Limits limits_;                          // guarded by mutex_
  bool is_over_ = false;                   // guarded by mutex_
  std::atomic<double> grace_seconds_ = 0;  // once stopping_
  std::atomic<bool> stopping_ = false, ended_ = false;
  ServedDevices devices_;
  ClientUsage usage_;
  OpenUploads uploads_;
  SceneStore scenes_;
  std::optional<FreedMemory> freed_;  // from here on used by the watch thread only; none: it stays with the process
  uint64_t watches_ = 0;
  std::thread watch_;
};

}  // namespace collided::server
