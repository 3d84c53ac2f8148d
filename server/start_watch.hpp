#pragma once
// Lets SIGTERM and SIGINT end the daemon while it starts, which may take long: a device may be slow to come.

#include <signal.h>

#include <atomic>
#include <thread>

namespace collided::server {

/// Before any thread exists: from now on both signals end the process with exit code 0, by a handler of the main
/// thread.
void exit_on_signals();

/// Blocks both signals for all threads from now on, and ends the process with exit code 0 if one comes while this
/// exists. One that comes later waits for sigwait().
class StartWatch {
 public:
  /// Throws std::system_error if there is no thread.
  StartWatch();
  ~StartWatch();
  StartWatch(const StartWatch&) = delete;
  StartWatch& operator=(const StartWatch&) = delete;

 private:
  void run() const;

  std::atomic<bool> is_over_ = false;
  std::thread thread_;
};

}  // namespace collided::server
