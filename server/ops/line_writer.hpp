#pragma once
// Writes lines to a file descriptor that may block for a while, or forever: only a thread of its own waits for it.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>

namespace collided::server {

/// Lives until the process ends, as its thread may never return from a write: so only make() creates one.
class LineWriter {
 public:
  /// Maximum number of bytes that wait.
  static constexpr size_t kMaxBytes = size_t{1} << 20;
  /// Makes the line that tells how many were dropped.
  using Report = std::function<std::string(uint64_t dropped)>;

  static LineWriter& make(int fd, Report report);

  /// Queues a line, or drops it if too much waits already. Never blocks.
  void write(std::string line);
  /// Waits until all lines so far are written; false after `timeout`.
  bool drain(std::chrono::milliseconds timeout);
  /// As drain(), but safe in a signal handler.
  void drain_in_signal(std::chrono::milliseconds timeout) const noexcept;
  /// Lines dropped so far: because too much waited, or because they could not be written.
  uint64_t dropped() const { return dropped_; }

 private:
  LineWriter(int fd, Report report) : fd_(fd), report_(std::move(report)) {}

  [[noreturn]] void run();
  std::string next();
  void put(const std::string& line);
  void report_dropped();

  const int fd_;
  const Report report_;
  std::atomic<uint64_t> dropped_ = 0;
  std::atomic<size_t> left_ = 0;  // lines that wait or are being written
  uint64_t reported_ = 0;         // of dropped_; the writing thread's
  std::mutex mutex_;              // guards what follows
  std::condition_variable arrived_, written_;
  std::deque<std::string> lines_;
  size_t bytes_ = 0;
};

}  // namespace collided::server
