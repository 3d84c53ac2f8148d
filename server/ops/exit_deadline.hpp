#pragma once
// Ends a process that cannot stop by itself: gRPC closes no connection before its last write has finished, and a full
// Unix socket whose client neither reads nor closes has no timeout.

#include <condition_variable>
#include <mutex>
#include <thread>

namespace collided::server {

class ExitDeadline {
 public:
  /// Unless this object is destroyed within `seconds`, logs a line and exits with `code`.
  ExitDeadline(double seconds, int code);
  ~ExitDeadline();
  ExitDeadline(const ExitDeadline&) = delete;
  ExitDeadline& operator=(const ExitDeadline&) = delete;

 private:
  void wait(double seconds, int code);

  std::mutex mutex_;
  std::condition_variable met_;
  bool is_met_ = false;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace collided::server
