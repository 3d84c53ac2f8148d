#pragma once
// One watcher of a scene: which frames it is shown, and when. Its mailbox has room for one frame, the latest. No gRPC
// here.

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/frames/watched.hpp"
#include "server/scenes/scene.hpp"
#include "server/scenes/scene/watching.hpp"
#include "server/service/watch_options.hpp"

namespace collided::server {

/// What a watcher is shown of a frame.
struct WatchedUpdate {
  std::shared_ptr<const WatchedFrame> frame;
  std::vector<std::shared_ptr<const std::string>> positions;  ///< one for each of its meshes
  uint32_t vertex_stride = 0;                                 ///< of these
  uint64_t skipped = 0;                                       ///< frames that it was not shown since the last one
};

/// Where a watcher's frames go: the transport.
class WatchSink {
 public:
  virtual ~WatchSink() = default;
  /// The next one comes after ready(). By the scene's worker, which must not wait.
  virtual void show(WatchedUpdate update) = 0;
  /// From any thread, once at most.
  virtual void ended(const std::exception_ptr& why) = 0;
  /// Its messages may have so many bytes from now on. By the scene's worker. Throws what the quota throws.
  virtual void reserve(uint64_t message_bytes) = 0;
};

class Watcher final : public SceneWatcher, public std::enable_shared_from_this<Watcher> {
 public:
  /// Does not keep the scene's lease alive. Shows nothing before the first ready().
  Watcher(std::shared_ptr<Scene> scene, WatchOptions options, std::shared_ptr<const ScenePlan> plan,
          std::weak_ptr<WatchSink> sink)
      : scene_(std::move(scene)),
        options_(std::move(options)),
        sink_(std::move(sink)),
        plan_(std::move(plan)),
        samples_(options_.samples) {}

  const Scene& scene() const { return *scene_; }
  const WatchOptions& options() const { return options_; }
  /// The client has read what it was shown.
  void taken();
  /// It can be shown another frame: the latest if it has not seen that, else the next one.
  void ready();
  /// The transport is gone: leaves the scene. The sink is not called again.
  void close() { leave(); }

  uint32_t max_contacts() const override { return options_.max_contacts; }
  void answered(const std::shared_ptr<const WatchedFrame>& frame) override;
  void end(const std::exception_ptr& why) override;
  double unread_seconds() const override;

 private:
  bool is_due_locked() const { return is_ready_ && latest_ && unseen_ >= options_.frame_interval; }
  /// False if it has left already.
  bool leave();
  void show_latest();
  std::optional<WatchedUpdate> take_latest();
  void follow_edits(WatchSink& sink);

  const std::shared_ptr<Scene> scene_;
  const WatchOptions options_;
  const std::weak_ptr<WatchSink> sink_;
  std::shared_ptr<const ScenePlan> plan_;  // that its samples are of; owned by the worker, as they are
  VertexSamples samples_;
  mutable std::mutex mutex_;                    // guards what follows
  std::shared_ptr<const WatchedFrame> latest_;  // if it has not been shown
  uint64_t unseen_ = 0;                         // frames since the one that was shown last
  std::optional<Clock::time_point> unread_since_ = scene_->now();
  bool is_ready_ = false, is_closed_ = false;
};

}  // namespace collided::server
