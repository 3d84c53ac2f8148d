#pragma once
// One stream of frames to one scene, whatever it travels on: order, delivery policy, take-over, end. No gRPC here.

#include <atomic>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <string>

#include "server/scenes/frame_run.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

/// Every frame is answered, or older ones that wait give way to later ones.
enum class Delivery { kLossless, kLatestWins };

/// Where a session's answers go. All but the last come one at a time from the scene's worker, `opened` first, answers
/// in the order of the frames.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// No frame of an earlier stream is applied any more; snapshot() has the last one that was.
  virtual void opened(const Scene& scene) = 0;
  virtual void answered(const Scene& scene, AnsweredFrame frame) = 0;
  virtual void refused(uint64_t frame_id, const std::exception_ptr& error) = 0;
  virtual void skipped(uint64_t frame_id) = 0;
  /// The daemon is about to stop.
  virtual void draining(double seconds) = 0;
  /// From any thread, perhaps twice. What the worker brings at the same time may still come, and counts no more.
  virtual void ended(const std::exception_ptr& why) = 0;
};

class FrameSession : public std::enable_shared_from_this<FrameSession> {
 public:
  /// Becomes the stream of the scene, and posts its opening to the worker. An empty token does not take over a scene
  /// that has a stream. Throws FailedPrecondition, PermissionDenied.
  static std::shared_ptr<FrameSession> open(SceneUse scene, const std::string& resume_token, Delivery delivery,
                                            std::shared_ptr<FrameSink> sink);

  Scene& scene() const { return *scene_; }
  /// Takes a frame; it is answered after all before it.
  void submit(PendingFrame frame);
  /// Whether answers pile up: frames that wait are not begun until hold(false). Called again with each that was taken.
  void hold(bool is_held);
  /// The transport is gone: drops what waits, cancels what runs, and leaves the scene. The sink hears no more of it.
  void close();
  /// The daemon ends the stream.
  void end(const std::exception_ptr& why);
  void announce_stop(double seconds);
  bool is_closed() const { return closed_; }
  /// Seconds since the last frame came or was begun; 0 while one runs or waits for its turn, but not while it waits for
  /// the client to take the answers before it.
  double idle_seconds() const;
  /// Frames that wait.
  size_t waiting() const;

 private:
  struct Waiting {
    PendingFrame frame;
    bool is_skipped = false;
  };

  FrameSession(SceneUse scene, Delivery delivery, std::shared_ptr<FrameSink> sink)
      : scene_(scene.scene()), delivery_(delivery), use_(std::move(scene)), sink_(std::move(sink)) {}

  // `_locked`: the caller holds mutex_.
  void skip_older_locked(const PendingFrame& latest);
  void begin_locked();
  std::shared_ptr<FrameSink> sink() const;
  void work();
  void run(Waiting& next, FrameSink& sink);
  void fail(uint64_t frame_id, const std::exception_ptr& error, FrameSink& sink);

  const std::shared_ptr<Scene> scene_;
  const Delivery delivery_;
  std::atomic<bool> closed_ = false;
  mutable std::mutex mutex_;  // guards what follows
  SceneUse use_;              // until it is closed: a transport may keep its session for longer
  std::shared_ptr<FrameSink> sink_;
  std::deque<Waiting> waiting_;
  Clock::time_point last_active_ = scene_->now();
  bool is_held_ = false;
  bool is_working_ = false;
};

}  // namespace collided::server
