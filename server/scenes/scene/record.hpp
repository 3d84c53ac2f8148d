#pragma once
// The record of a scene: its identity, its visible state, its stream and watchers, and how it ended. No gRPC here.

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "server/auth/client.hpp"
#include "server/scenes/scene/plan.hpp"
#include "server/scenes/scene/stream.hpp"
#include "server/scenes/scene/watching.hpp"

namespace collided::server {

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

/// Says why and when a scene ended.
struct SceneEnd {
  bool is_expired = false;  ///< false: deleted by its client
  double lease_seconds = 0;
  std::chrono::steady_clock::time_point when{};

  /// Such as "was deleted"; `now` dates it.
  std::string text(std::chrono::steady_clock::time_point now) const;
};

/// Safe from any thread: a mutex guards the state, the end and the stream, and is not held while a stream or a watcher
/// is called.
class SceneRecord {
 public:
  /// `plan`: without its triangles.
  SceneRecord(SceneIdentity identity, ScenePlan plan);

  const std::string& id() const { return identity_.id; }
  const SceneIdentity& identity() const { return identity_; }
  /// Returns the plan as the last edit left it.
  std::shared_ptr<const ScenePlan> plan() const;
  SceneSnapshot snapshot() const;
  /// True once a detector has been built.
  bool is_ready() const;
  uint64_t last_frame_id() const;
  /// Number of edits so far.
  uint64_t edits() const;
  /// Sum of the snapshot's memory, without a copy of it.
  uint64_t device_bytes() const;
  /// `mesh 1 ("tip")`, for messages.
  std::string mesh_name(uint32_t mesh) const;
  /// Returns true if a mesh excludes rest pairs and no frame has been applied yet that defines them.
  bool awaits_rest() const { return excludes_rest_pairs_ && last_frame_id() == 0; }
  /// Throws FailedPrecondition, naming `field`, for a set.
  void check_is_one(const std::string& field) const;

  /// Makes `stream` the scene's one stream. Returns the stream that it replaces, or null. Throws NotFound once the
  /// scene is closed, PermissionDenied for a wrong token, FailedPrecondition if there is a stream and no token.
  std::shared_ptr<SceneStream> begin_stream(const std::shared_ptr<SceneStream>& stream, const std::string& token);
  /// Returns true if begin_stream() with this token would replace a stream.
  bool would_take_over(const std::string& token) const;
  /// Does nothing if another one is the scene's stream.
  void end_stream(const SceneStream& stream);
  std::shared_ptr<SceneStream> stream() const;
  /// Shows the watcher every frame from now on, until end_watch() or close(). Throws NotFound once the scene is closed.
  void begin_watch(std::shared_ptr<SceneWatcher> watcher);
  void end_watch(const SceneWatcher& watcher) { watchers_.remove(watcher); }
  const SceneWatchers& watchers() const { return watchers_; }

  /// Answers later frames and uploads with NotFound, and ends the stream and all watches.
  void close(const SceneEnd& end);
  /// Takes no lock, so that a frame's checkpoints may ask.
  bool is_closed() const { return closed_; }
  /// Throws NotFound once the scene is closed.
  void check_open() const;

  // The worker's thread alone calls these:

  /// Shows what the detector has and holds. The scene is ready from now on.
  void show(const Detector& detector, uint64_t host_bytes);
  void show_frame(uint64_t frame_id);
  void show_edit(std::shared_ptr<const ScenePlan> plan, uint64_t vertices);

 private:
  void check_token(const std::string& token) const;

  const SceneIdentity identity_;
  const bool excludes_rest_pairs_;  // a mesh of the plan that it was created with does
  SceneWatchers watchers_;
  std::atomic<bool> closed_ = false;
  mutable std::mutex mutex_;  // guards what follows
  SceneSnapshot shown_;
  SceneEnd end_;  // written before closed_ is set, and read without the lock afterwards
  std::shared_ptr<SceneStream> stream_;
};

}  // namespace collided::server
