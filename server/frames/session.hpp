#pragma once
// One stream of frames to one scene, on any transport: order, delivery policy, take-over, end. No gRPC here.

#include <atomic>
#include <exception>
#include <list>
#include <memory>
#include <mutex>
#include <string>

#include "server/frames/run.hpp"
#include "server/ops/log.hpp"
#include "server/refusals/status.hpp"
#include "server/scenes/scene.hpp"
#include "server/scenes/scene/stream.hpp"

namespace collided::server {

/// Every frame is answered, or waiting frames give way to newer ones.
enum class Delivery { kLossless, kLatestWins };

/// Where a session's answers go: the transport. All calls but ended() come one at a time from the scene's worker,
/// opened() first, answers in the order of the frames.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// No further frame of an earlier stream will be applied; snapshot() has the last one that was.
  virtual void opened(const Scene& scene) = 0;
  /// Sends the frame's contacts, and completes its cost by encode_contacts().
  virtual void answered(const Scene& scene, const std::shared_ptr<AnsweredFrame>& frame) = 0;
  virtual void refused(uint64_t frame_id, const Failure& failure) = 0;
  virtual void skipped(uint64_t frame_id) = 0;
  /// The daemon is about to stop.
  virtual void draining(double seconds) = 0;
  /// From any thread, perhaps twice. A call that the worker makes at that moment may still arrive, and is to be
  /// ignored.
  virtual void ended(const std::exception_ptr& why) = 0;
};

class FrameSession final : public SceneStream, public std::enable_shared_from_this<FrameSession> {
 public:
  /// Becomes the scene's stream, and posts its opening to the worker. An empty token does not take over a scene that
  /// has a stream. `ids` go into the log lines of its frames. Throws FailedPrecondition, PermissionDenied.
  static std::shared_ptr<FrameSession> open(SceneUse scene, const std::string& resume_token, Delivery delivery,
                                            std::shared_ptr<FrameSink> sink, CallIds ids = {});

  Scene& scene() const { return *scene_; }
  /// Queues a frame; it is answered after all earlier ones.
  void submit(PendingFrame frame);
  /// hold(true): starts no waiting frame while the client does not take its answers. Called again with each answer that
  /// it takes.
  void hold(bool is_held);
  /// The transport is gone: drops waiting frames, cancels the running one, and leaves the scene. The sink is not called
  /// again.
  void close();
  bool is_closed() const { return closed_; }

  void end(const std::exception_ptr& why) override;
  void announce_stop(double seconds) override;
  /// Waiting for the client to take earlier answers counts as idle.
  double idle_seconds() const override;
  size_t waiting() const override;

 private:
  struct Waiting {
    PendingFrame frame;
    bool is_skipped = false;
  };

  FrameSession(SceneUse scene, Delivery delivery, std::shared_ptr<FrameSink> sink, CallIds ids)
      : scene_(scene.scene()),
        delivery_(delivery),
        ids_(std::move(ids)),
        use_(std::move(scene)),
        sink_(std::move(sink)) {}

  // `_locked`: the caller holds mutex_.
  void skip_older_locked(const PendingFrame& latest);
  void start_next_locked();
  std::shared_ptr<FrameSink> sink() const;
  void work();
  void post(std::function<void()> job);
  void run(Waiting& next, FrameSink& sink);
  void answer(const std::shared_ptr<AnsweredFrame>& answered, bool is_trial, FrameSink& sink);
  void fail(uint64_t frame_id, const std::exception_ptr& error, FrameSink& sink);

  const std::shared_ptr<Scene> scene_;
  const Delivery delivery_;
  const CallIds ids_;
  std::atomic<bool> closed_ = false, knows_of_stop_ = false;
  mutable std::mutex mutex_;  // guards what follows
  SceneUse use_;              // until it is closed: a transport may keep its session for longer
  std::shared_ptr<FrameSink> sink_;
  std::list<Waiting> waiting_;
  Clock::time_point last_active_ = scene_->now();
  bool is_held_ = false;
  bool is_working_ = false;
};

}  // namespace collided::server
