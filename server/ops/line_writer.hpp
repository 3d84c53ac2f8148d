#pragma once
// Lines on their way to a file descriptor, which may take none for a while, or for ever: nobody waits for it but a
// thread of its own.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>

namespace collided::server {

/// Lives until the process ends: its thread may never come back from a write. Hence only make() makes one.
class LineWriter {
 public:
  /// Bytes that wait at most.
  static constexpr size_t kMaxBytes = size_t{1} << 20;
  /// Makes the line that tells how many were dropped.
  using Report = std::function<std::string(uint64_t dropped)>;

  static LineWriter& make(int fd, Report report);

  /// Takes a line, or drops it where too much waits already. Never waits.
  void write(std::string line);
  /// Waits until all that came before is written; false after `most`.
  bool drain(std::chrono::milliseconds most);
  /// As drain(), but safe within a signal handler.
  void drain_in_signal(std::chrono::milliseconds most) const noexcept;
  /// Lines that were dropped since the beginning: too much waited, or they could not be written.
  uint64_t dropped() const { return dropped_; }

 private:
  LineWriter(int fd, Report report) : fd_(fd), report_(std::move(report)) {}

  [[noreturn]] void run();
  std::string next();
  void put(const std::string& line);
  void tell_dropped();

  const int fd_;
  const Report report_;
  std::atomic<uint64_t> dropped_ = 0;
  std::atomic<size_t> left_ = 0;  // lines that wait or are being written
  uint64_t told_ = 0;             // of dropped_; of the writing thread alone
  std::mutex mutex_;              // guards what follows
  std::condition_variable come_, gone_;
  std::deque<std::string> lines_;
  size_t bytes_ = 0;
};

}  // namespace collided::server
