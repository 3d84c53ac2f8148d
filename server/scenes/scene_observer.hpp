#pragma once
// Interface that is notified of events of scenes and their frames. No gRPC here.

#include <cstdint>
#include <exception>
#include <string>

#include "server/ops/counters.hpp"

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
  /// Something happened to the scene so many times that is counted, and no more.
  virtual void counted(const Scene& scene, CounterId id, uint64_t times) = 0;
  /// The scene was deleted because its lease ran out.
  virtual void expired(const Scene& scene) = 0;
  /// The engine reports that the scene's device failed.
  virtual void device_failed(const Scene& scene, const std::string& why) = 0;
};

}  // namespace collided::server
