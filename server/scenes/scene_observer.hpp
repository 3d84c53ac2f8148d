#pragma once
// Interface that is notified of events of scenes and their frames. No gRPC here.

#include <cstdint>
#include <exception>
#include <string>

namespace collided::server {

class Scene;
struct AnsweredFrame;

/// Called from any thread.
class SceneObserver {
 public:
  virtual ~SceneObserver() = default;
  /// A frame was answered; its cost is complete.
  virtual void answered(const Scene& scene, const AnsweredFrame& frame) = 0;
  virtual void refused(const Scene& scene, uint64_t frame_id, const std::exception_ptr& error) = 0;
  virtual void skipped(const Scene& scene, uint64_t frame_id) = 0;
  /// So many frames were not shown to one watcher.
  virtual void not_shown(const Scene& scene, uint64_t frames) = 0;
  /// A stream was opened with the scene's resume token.
  virtual void resumed(const Scene& scene) = 0;
  /// The scene was deleted because its lease ran out.
  virtual void expired(const Scene& scene) = 0;
  /// The engine reports that the scene's device failed.
  virtual void device_failed(const Scene& scene, const std::string& why) = 0;
};

}  // namespace collided::server
