#pragma once
// A resident scene: its record and lease, its uploads, its engine and its worker. No gRPC here.

#include <memory>
#include <string>
#include <utility>

#include "server/devices/served_devices.hpp"
#include "server/ops/clock.hpp"
#include "server/scenes/scene/engine.hpp"
#include "server/scenes/scene/lease.hpp"
#include "server/scenes/scene/plan.hpp"
#include "server/scenes/scene/record.hpp"
#include "server/scenes/scene/uploads.hpp"
#include "server/scenes/scene/worker.hpp"
#include "server/scenes/scene_observer.hpp"

namespace collided::server {

/// Holds what all scenes share. Everything that it refers to outlives them.
struct SceneContext {
  ServedDevices& devices;
  SceneObserver& observer;
  std::string endpoint = {};  ///< address advertised to clients for streaming; empty: the one they used
  Now now = Clock::now;       ///< of leases and idle streams
  std::string name = {};      ///< of the daemon: begins the ids of scenes; empty: nothing does
};

/// Puts the pieces together: each says what it guards, and none calls another one with its lock held.
class Scene {
 public:
  /// Throws LimitExceeded if its triangles and meshes alone exceed a limit.
  Scene(SceneIdentity identity, ScenePlan plan, SceneContext context);

  const std::string& id() const { return record_.id(); }
  const SceneIdentity& identity() const { return record_.identity(); }
  /// The plan without its triangles, as the last edit left it. From any thread.
  std::shared_ptr<const ScenePlan> plan() const { return record_.plan(); }
  SceneSnapshot snapshot() const;
  SceneObserver& observer() const { return context_.observer; }
  Clock::time_point now() const { return context_.now(); }
  const std::string& endpoint() const { return context_.endpoint; }
  /// The quota of all memory that the scene holds, within its budget and its client's limits; of a sharded scene, of
  /// what is the scene's as a whole.
  const std::shared_ptr<DeviceBytes>& quota() const { return quota_.whole; }

  SceneRecord& record() { return record_; }
  const SceneRecord& record() const { return record_; }
  SceneUploads& uploads() { return uploads_; }
  SceneEngine& engine() { return engine_; }
  const SceneEngine& engine() const { return engine_; }
  SceneWorker& worker() { return worker_; }

  /// As SceneRecord::begin_stream(). Throws FailedPrecondition if triangles are still missing, too.
  std::shared_ptr<SceneStream> begin_stream(const std::shared_ptr<SceneStream>& stream, const std::string& token);
  /// Returns true if the scene has been unused for longer than its lease.
  bool is_expired(Clock::time_point now) const { return lease_.is_expired(now); }

  // The worker's thread alone calls these:

  /// Adds all triangles that a mesh awaits, and builds the detector once no mesh awaits any.
  void add_triangles(uint32_t mesh, ReceivedTriangles& triangles);
  /// Returns true if all triangles have arrived but no detector could be built.
  bool unusable() const { return !record_.is_ready() && !uploads_.awaits_any(); }
  /// Frees the scene's memory.
  void release();

 private:
  friend class SceneUse;

  const SceneContext context_;
  const SceneQuota quota_;
  SceneRecord record_;
  SceneLease lease_;
  SceneUploads uploads_;
  SceneEngine engine_;
  SceneWorker worker_;  // last, so that its thread ends before the other members are destroyed
};

/// A scene in use by a call or a stream: its lease is suspended meanwhile and restarts afterwards.
class SceneUse {
 public:
  SceneUse() = default;
  explicit SceneUse(std::shared_ptr<Scene> scene) : scene_(std::move(scene)) { scene_->lease_.begin_use(); }
  SceneUse(const SceneUse& other) : scene_(other.scene_) {
    if (scene_) scene_->lease_.begin_use();
  }
  SceneUse(SceneUse&&) noexcept = default;
  SceneUse& operator=(SceneUse other) noexcept {
    scene_.swap(other.scene_);
    return *this;
  }
  ~SceneUse() {
    if (scene_) scene_->lease_.end_use();
  }

  explicit operator bool() const { return scene_ != nullptr; }
  Scene* operator->() const { return scene_.get(); }
  Scene& operator*() const { return *scene_; }
  const std::shared_ptr<Scene>& scene() const { return scene_; }

 private:
  std::shared_ptr<Scene> scene_;
};

}  // namespace collided::server
