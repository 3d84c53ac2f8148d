#pragma once
// The watchers of a scene's frames, as seen by the scene and its host. No gRPC here.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <vector>

namespace collided::server {

struct WatchedFrame;

/// Thread-safe.
class SceneWatcher {
 public:
  virtual ~SceneWatcher() = default;
  /// Maximum number of contacts of each kind that it shows.
  virtual uint32_t max_contacts() const = 0;
  /// A frame was answered. By the scene's worker, which must not wait.
  virtual void answered(const std::shared_ptr<const WatchedFrame>& frame) = 0;
  /// Ends the watch; its client is told why.
  virtual void end(const std::exception_ptr& why) = 0;
  /// Seconds that the client has left a message unread; 0 if it has read them all.
  virtual double unread_seconds() const = 0;
};

/// Thread-safe.
class SceneWatchers {
 public:
  using List = std::vector<std::shared_ptr<SceneWatcher>>;

  void add(std::shared_ptr<SceneWatcher> watcher);
  /// Does nothing for one that is not there.
  void remove(const SceneWatcher& watcher);
  /// Takes no lock, so that a frame that nobody watches costs nothing.
  size_t size() const { return size_; }
  List all() const;

 private:
  std::atomic<size_t> size_ = 0;
  mutable std::mutex mutex_;
  List watchers_;  // guarded by mutex_
};

}  // namespace collided::server
