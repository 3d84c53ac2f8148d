#pragma once
// Whether the daemon serves, and if not, why: read by health checks and calls, changed by main and by a failed device.

#include <functional>
#include <mutex>
#include <string>

namespace collided::server {

/// Thread-safe. A failure is final: neither serve() nor drain() undoes it.
class Lifecycle {
 public:
  enum class State { kStarting, kServing, kDraining, kFailed };
  struct Status {
    State state = State::kStarting;
    std::string reason;    ///< of a failure
    std::string obstacle;  ///< what keeps new clients out now; empty: nothing

    /// Whether new clients should come.
    bool ready() const { return state == State::kServing && obstacle.empty(); }
    /// One line: "ready", "not ready: <obstacle>", "starting", "draining" or "failed: <reason>".
    std::string text() const;
  };

  /// `wake` is called at the first failure, by the thread that reports it; it must not block.
  explicit Lifecycle(std::function<void()> wake = [] {}) : wake_(std::move(wake)) {}

  /// The addresses are bound.
  void serve();
  /// The daemon is asked to stop.
  void drain();
  /// The daemon cannot go on (a device failed for good); the first reason is kept.
  void fail(const std::string& reason);

  /// Sets what keeps new clients out; "" once nothing does. Connected clients are served meanwhile.
  void set_obstacle(const std::string& obstacle);

  Status status() const;
  bool serving() const { return status().state == State::kServing; }
  bool failed() const { return status().state == State::kFailed; }

 private:
  const std::function<void()> wake_;
  mutable std::mutex mutex_;
  Status status_;  // guarded by mutex_
};

}  // namespace collided::server
