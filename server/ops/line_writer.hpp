#pragma once
// Writes lines to a file descriptor that may block for a while, or forever: only the writer's own thread waits.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>

namespace collided::server {

/// Lives until the process ends, as its thread may never return from a write; hence only make() creates one.
class LineWriter {
 public:
  /// Maximum number of queued bytes.
  static constexpr size_t kMaxBytes = size_t{1} << 20;
  /// Returns a line that says how many were dropped.
  using Report = std::function<std::string(uint64_t dropped)>;

  static LineWriter& make(int fd, Report report);

  /// Queues a line, or drops it if the queue is full. Never blocks.
  void write(std::string line);
  /// Waits until all lines so far are written; false after `timeout`.
  bool drain(std::chrono::milliseconds timeout);
  /// As drain(), but safe in a signal handler.
  void drain_in_signal(std::chrono::milliseconds timeout) const noexcept;
  /// Lines dropped so far, because the queue was full or because they could not be written.
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
  std::atomic<size_t> left_ = 0;  // lines queued or being written
  uint64_t reported_ = 0;         // of dropped_; owned by the writing thread
  std::mutex mutex_;              // guards what follows
  std::condition_variable arrived_, written_;
  std::deque<std::string> lines_;
  size_t bytes_ = 0;
};

}  // namespace collided::server
