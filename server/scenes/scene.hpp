#pragma once
// A resident scene: its plan, its detector, its worker, its one stream, its lease, and its visible state.
// No gRPC here.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "gpu/detector.hpp"
#include "server/auth/client.hpp"
#include "server/devices/device_bytes.hpp"
#include "server/devices/parted_bytes.hpp"
#include "server/devices/served_devices.hpp"
#include "server/devices/turns_of_scene.hpp"
#include "server/ops/clock.hpp"
#include "server/scenes/ended_scenes.hpp"
#include "server/scenes/scene/plan.hpp"
#include "server/scenes/scene/slot_pool.hpp"
#include "server/scenes/scene/stream.hpp"
#include "server/scenes/scene/watching.hpp"
#include "server/scenes/scene/worker.hpp"
#include "server/scenes/scene_observer.hpp"
#include "server/scenes/upload.hpp"

namespace collided::server {

/// The visible state of a scene at one moment.
struct SceneSnapshot {
  bool ready = false;
  std::string device;
  uint64_t vertices = 0, edges = 0, triangles = 0;
  std::vector<MemoryPart> memory;
  uint64_t last_frame_id = 0;
  uint64_t edits = 0;
  std::shared_ptr<const ScenePlan> plan;  ///< without its triangles
};

/// Names a scene and its owner. Fixed when the scene is created.
struct SceneIdentity {
  std::string id;
  std::string resume_token;  ///< a secret
  std::string request_id;    ///< of the request that created it; may be empty
  uint64_t fingerprint = 0;  ///< of that request
  Client owner;
  double lease_seconds = 0;
  size_t queue_capacity = 0;  ///< initial maximum of waiting unary frames
};

/// Holds what all scenes share. Everything that it refers to outlives them.
struct SceneContext {
  ServedDevices& devices;
  SceneObserver& observer;
  std::string endpoint = {};  ///< address advertised to clients for streaming; empty: the one they used
  Now now = Clock::now;       ///< of leases and idle streams
  std::string name = {};      ///< of the daemon: begins the ids of scenes; empty: nothing does
};

class Scene {
 public:
  /// Throws LimitExceeded if its triangles and meshes alone exceed a limit.
  Scene(SceneIdentity identity, ScenePlan plan, SceneContext context);

  const std::string& id() const { return identity_.id; }
  const SceneIdentity& identity() const { return identity_; }
  /// Of a scene in parts the first one's. No edit changes it.
  const Device& device() const { return device_; }
  /// All that it is on, each once, in order.
  const std::vector<Device>& devices() const { return devices_; }
  bool is_in_parts() const { return parted_ != nullptr; }
  /// The plan without its triangles, as the last edit left it. From any thread.
  std::shared_ptr<const ScenePlan> plan() const {
    const std::lock_guard lock(mutex_);
    return shown_.plan;
  }
  SceneWorker& worker() { return worker_; }
  SceneObserver& observer() const { return context_.observer; }
  Clock::time_point now() const { return context_.now(); }
  const std::string& endpoint() const { return context_.endpoint; }
  SceneSnapshot snapshot() const;
  /// Number of edits so far.
  uint64_t edits() const {
    const std::lock_guard lock(mutex_);
    return shown_.edits;
  }
  /// Sum of the snapshot's memory, without a copy of it.
  uint64_t device_bytes() const;
  /// The quota of all memory that the scene holds, within its budget and its client's limits; of a scene in parts, of
  /// what is the scene's as a whole.
  const std::shared_ptr<DeviceBytes>& quota() const { return quota_; }
  /// Number of triangles that a mesh still awaits.
  uint64_t awaited(uint32_t mesh) const;
  /// `mesh 1 ("tip")`, for messages.
  std::string mesh_name(uint32_t mesh) const;
  /// Reserves a mesh for one upload, so that open uploads hold no more than the scene awaits. Throws
  /// FailedPrecondition.
  void begin_upload(uint32_t mesh);
  void end_upload(uint32_t mesh);
  /// Whether all triangles have arrived but no detector could be built.
  bool unusable() const;

  /// Makes `stream` the scene's one stream. Returns the stream that it replaces, or null. Throws PermissionDenied for a
  /// wrong token, FailedPrecondition if there is a stream and no token, or triangles are still missing.
  std::shared_ptr<SceneStream> begin_stream(const std::shared_ptr<SceneStream>& stream, const std::string& token);
  /// Whether begin_stream() with this token would replace a stream.
  bool would_take_over(const std::string& token) const;
  /// Does nothing if another one is the scene's stream.
  void end_stream(const SceneStream& stream);
  std::shared_ptr<SceneStream> stream() const;
  /// Throws NotFound once it is closed.
  void check_open() const;
  /// Throws what its building failed with. On the worker's thread.
  void check_built() const;
  /// Throws FailedPrecondition, naming `field`, for a set.
  void check_is_one(const std::string& field) const;
  /// Shows the watcher every frame from now on, until end_watch() or close(). Throws NotFound once it is closed.
  void begin_watch(std::shared_ptr<SceneWatcher> watcher);
  void end_watch(const SceneWatcher& watcher) { watchers_.remove(watcher); }
  const SceneWatchers& watchers() const { return watchers_; }
  /// Answers later frames and uploads with NotFound, and ends the stream and all watches.
  void close(const SceneEnd& end);

  /// A free or new slot for one frame; its last reference returns it to the scene. From any thread. Throws NotFound
  /// once the scene is deleted.
  std::shared_ptr<FrameSlot> take_slot();
  /// Whether a mesh excludes rest pairs, and no frame was applied yet that tells which those are.
  bool awaits_rest() const {
    if (!excludes_rest_pairs_) return false;
    const std::lock_guard lock(mutex_);
    return shown_.last_frame_id == 0;
  }
  /// Maximum bytes of positions in a frame.
  uint64_t max_position_bytes() const;
  /// Waits for this scene's turn on its devices.
  TurnsOfScene::Turn take_turn(const std::function<bool()>& cancelled) { return turns_.take(cancelled); }
  /// Later frames take turns of this client: the one that sends them. From any thread.
  void charge_to(const TurnPath& client) { turns_.charge_to(client); }

  /// Whether nobody has used the scene for longer than its lease.
  bool is_expired(std::chrono::steady_clock::time_point now) const;

  // On the worker's thread only:

  /// Builds the detector, in turns of its client on the host, unless triangles are still missing.
  void build_if_complete();
  /// Adds all triangles that a mesh awaits, and builds the detector once no mesh awaits any.
  void add_triangles(uint32_t mesh, ReceivedTriangles& triangles);
  /// Checks and applies a frame; if it throws, the scene is unchanged. Throws FailedPrecondition if the scene was
  /// edited since the frame was checked.
  FrameResult apply(uint64_t frame_id, const FrameInput& frame, const FrameBasis& basis = {});
  const Topology& topology() const { return detector_->topology(); }
  /// Positions after the last frame that was applied, in the scene's format; those who ask for the same sample of one
  /// frame share them. Throws NotFound once the scene is deleted, ResourceExhausted, LimitExceeded, DeviceError.
  std::shared_ptr<const std::string> positions(const VertexSample& sample);
  /// Frees the scene's memory.
  void release();

 private:
  friend class SceneUse;

  void check_token(const std::string& token, bool has_stream) const;
  /// Throws FailedPrecondition for a set of worlds.
  bool awaits_triangles() const;
  [[noreturn]] void throw_awaits(const std::string& field) const;
  void make_detector();
  uint64_t host_bytes() const;
  FrameResult detect(uint64_t frame_id, const FrameInput& frame, const FrameBasis& basis);
  [[noreturn]] void throw_edited(uint64_t frame_id) const;
  void take_edit(const FrameBasis& basis, MemoryHold& making);
  void publish();
  void begin_use();
  void end_use();

  const SceneIdentity identity_;
  const SceneContext context_;
  const std::shared_ptr<PartedBytes> parted_;  // null unless it is in parts
  const std::shared_ptr<DeviceBytes> quota_;
  const Device device_;
  const std::vector<Device> devices_;
  TurnsOfScene turns_, host_turns_;   // of frames, and of building
  MemoryHold held_;                   // plan, triangles and topology; owned by the worker after construction
  std::exception_ptr build_failure_;  // owned by the worker
  bool excludes_rest_pairs_ = false;  // a mesh does; fixed after construction
  SceneSpec pending_;                 // the spec with its triangles, until the detector takes it
  std::shared_ptr<Detector> detector_;
  /// Of the last frame; owned by the worker.
  std::vector<std::pair<VertexSample, std::shared_ptr<const std::string>>> samples_;
  SceneWatchers watchers_;
  std::atomic<bool> closed_ = false;
  mutable std::mutex mutex_;  // guards what follows
  SceneSnapshot shown_;
  SceneEnd end_;  // once closed
  std::vector<uint64_t> awaited_;
  std::vector<bool> uploading_;
  std::shared_ptr<SceneStream> stream_;
  std::shared_ptr<SlotPool> slots_;  // null until there is a detector
  unsigned uses_ = 0;
  Clock::time_point last_use_ = now();
  SceneWorker worker_;  // last, so that its thread ends before the other members are destroyed
};

/// A scene in use by a call or a stream: its lease is suspended meanwhile and restarts afterwards.
class SceneUse {
 public:
  SceneUse() = default;
  explicit SceneUse(std::shared_ptr<Scene> scene) : scene_(std::move(scene)) { scene_->begin_use(); }
  SceneUse(const SceneUse& other) : scene_(other.scene_) {
    if (scene_) scene_->begin_use();
  }
  SceneUse(SceneUse&&) noexcept = default;
  SceneUse& operator=(SceneUse other) noexcept {
    scene_.swap(other.scene_);
    return *this;
  }
  ~SceneUse() {
    if (scene_) scene_->end_use();
  }

  explicit operator bool() const { return scene_ != nullptr; }
  Scene* operator->() const { return scene_.get(); }
  Scene& operator*() const { return *scene_; }
  const std::shared_ptr<Scene>& scene() const { return scene_; }

 private:
  std::shared_ptr<Scene> scene_;
};

}  // namespace collided::server
