#pragma once
// One thread that runs a scene's jobs in order, with a bounded queue for frames.

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
  /// Runs the queued jobs, then ends the thread.
  ~SceneWorker();
  SceneWorker(const SceneWorker&) = delete;
  SceneWorker& operator=(const SceneWorker&) = delete;

  /// Queues a frame; false if the queue is full.
  bool try_post(Job job);
  /// Applies to new frames; queued ones stay.
  void set_capacity(size_t capacity);
  /// Queues a control job, which is never refused.
  void post(Job job);
  /// A job is about to arrive: wakes an idle thread, which polls briefly instead of sleeping.
  void wake_early();
  /// Waits until all jobs queued so far have run. Not from the worker's own thread.
  void flush();

 private:
  struct State;
  static void run(const std::shared_ptr<State>& state);
  static bool poll_awake(State& state, std::unique_lock<std::mutex>& lock);

  std::shared_ptr<State> state_;
  std::thread thread_;
};

}  // namespace collided::server
