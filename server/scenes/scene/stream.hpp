#pragma once
// A scene's one stream of frames, as seen by the scene and its host. No gRPC here.

#include <cstddef>
#include <exception>

namespace collided::server {

/// Thread-safe.
class SceneStream {
 public:
  virtual ~SceneStream() = default;
  /// Ends the stream; its client is told why.
  virtual void end(const std::exception_ptr& why) = 0;
  /// Tells the client, once, that the daemon stops in `seconds`.
  virtual void announce_stop(double seconds) = 0;
  /// Seconds since the last frame arrived or started; 0 while one runs or waits for its turn.
  virtual double idle_seconds() const = 0;
  /// Number of waiting frames.
  virtual size_t waiting() const = 0;
};

}  // namespace collided::server
