#pragma once
// One thread that runs a scene's work in order, with a bounded queue for frames.

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace collided::server {

class SceneWorker {
 public:
  using Job = std::function<void()>;  ///< must not throw

  explicit SceneWorker(size_t capacity);
  /// Runs what is queued, then ends the thread.
  ~SceneWorker();
  SceneWorker(const SceneWorker&) = delete;
  SceneWorker& operator=(const SceneWorker&) = delete;

  /// Queues a frame; false if the queue is full.
  bool try_post(Job job);
  /// For frames from now on; those that wait stay.
  void set_capacity(size_t capacity);
  /// Queues control work, which is never refused.
  void post(Job job);
  /// Work is on its way: a thread that has none wakes up meanwhile, and waits for it awake, though not for long.
  void expect();
  /// Waits until all that is queued now has run. Not from the worker's own thread.
  void flush();

 private:
  struct State;
  static void run(const std::shared_ptr<State>& state);
  static bool wait_awake(State& state, std::unique_lock<std::mutex>& lock);

  std::shared_ptr<State> state_;
  std::thread thread_;
};

}  // namespace collided::server
