#pragma once
// Runs work on the host for calls of clients: it checks messages, looks up scenes and makes answers. Jobs run in fair
// turns, on as many threads as there are turns. So no thread waits for a turn, and no client's calls wait behind
// another's. No gRPC here.

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

#include "server/devices/turns.hpp"

namespace collided::server {

/// Thread-safe.
class ClientWork {
 public:
  using Job = std::function<void()>;  ///< must neither throw nor wait for a turn

  /// `turns` outlives it.
  explicit ClientWork(Turns& turns);
  /// Waits until all jobs are done.
  ~ClientWork();
  ClientWork(const ClientWork&) = delete;
  ClientWork& operator=(const ClientWork&) = delete;

  /// Jobs of one client begin in the order of the calls. If this throws, as memory is short, the job does not run.
  void post(const TurnPath& client, Job job);
  /// Jobs that are not done.
  size_t size() const;

 private:
  struct Task;
  using Tasks = std::list<Task>;
  void run();
  bool is_idle() const;

  Turns& turns_;
  mutable std::mutex mutex_;  // guards what follows; taken while the turns' own is held, so never the other way
  std::condition_variable changed_;
  Tasks waiting_, granted_;  // for their turns, then for a thread
  size_t running_ = 0;
  bool is_over_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace collided::server
