#pragma once
// An upload of one mesh's triangles. No gRPC here.

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/scenes/scene/uploads.hpp"

namespace collided::server {

class Scene;
class SceneUse;

/// One call that uploads a mesh. The call's thread and those that end calls whose clients are silent race here: only
/// one of them ends it.
class Upload {
 public:
  using Clock = std::chrono::steady_clock;

  /// `fail` ends the call; called at most once, by end_if_stale().
  Upload(std::function<void(const std::exception_ptr&)> fail, Clock::time_point now);
  ~Upload();

  /// Starts waiting for the next chunk, which `read` requests; does nothing if the upload has been ended.
  void wait(const std::function<void()>& read);
  /// A chunk has arrived; false if the upload has been ended.
  bool receive(Clock::time_point now);
  /// False if it has been ended already.
  bool end();
  /// Ends the upload if it has waited for longer than `limit` (TimedOut), or if its scene is gone (NotFound).
  void end_if_stale(Clock::time_point now, std::chrono::duration<double> limit);

  // By the call's own thread, between receive() and wait() or end():

  /// Reserves the mesh for this upload; `ticket` counts it among its client's open streams. Throws InvalidInput,
  /// FailedPrecondition.
  void begin(const SceneUse& scene, uint32_t mesh, std::shared_ptr<void> ticket);
  /// Null before begin().
  Scene* scene() const;
  uint32_t mesh() const { return mesh_; }
  std::string mesh_name() const;  ///< with its index, for messages
  ReceivedTriangles& triangles() { return *triangles_; }
  /// Accounts for `count` more triangles. Throws InvalidInput for more than the mesh awaits, LimitExceeded.
  void reserve(uint64_t count);

 private:
  enum class State { kWorking, kWaiting, kOver };

  std::exception_ptr stale_reason(Clock::time_point now, std::chrono::duration<double> limit) const;
  void release();

  const std::function<void(const std::exception_ptr&)> fail_;
  std::mutex mutex_;  // guards what follows; in kWorking the data belong to the call's thread
  State state_ = State::kWorking;
  Clock::time_point last_chunk_;
  std::shared_ptr<void> ticket_;
  std::unique_ptr<SceneUse> scene_;
  uint32_t mesh_ = 0;
  std::unique_ptr<ReceivedTriangles> triangles_;
};

/// All open uploads.
class OpenUploads {
 public:
  void add(const std::shared_ptr<Upload>& upload);
  void end_stale(Upload::Clock::time_point now, std::chrono::duration<double> limit);

 private:
  std::mutex mutex_;
  std::vector<std::weak_ptr<Upload>> uploads_;  // guarded by mutex_
};

}  // namespace collided::server
