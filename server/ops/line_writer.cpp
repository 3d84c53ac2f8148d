// Writes lines to a file descriptor that may block.
#include "server/ops/line_writer.hpp"

#include <poll.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <thread>
#include <utility>

namespace collided::server {
namespace {

// False if the descriptor can no longer be written to.
bool write_all(int fd, const char* data, size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(fd, data, size);
    if (written >= 0) {
      data += written;
      size -= static_cast<size_t>(written);
    } else if (errno == EAGAIN) {  // another process has made the descriptor non-blocking
      pollfd writable{fd, POLLOUT, 0};
      poll(&writable, 1, -1);
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

}  // namespace

LineWriter& LineWriter::make(int fd, Report report) {
  auto* writer = new LineWriter(fd, std::move(report));  // owned by the thread, which nobody can join
  std::thread([writer] { writer->run(); }).detach();
  return *writer;
}

void LineWriter::write(std::string line) {
  const std::lock_guard lock(mutex_);
  if (bytes_ + line.size() > kMaxBytes) {
    ++dropped_;
    return;
  }
  ++left_;
  bytes_ += line.size();
  lines_.push_back(std::move(line));
  arrived_.notify_one();
}

bool LineWriter::drain(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return written_.wait_for(lock, timeout, [this] { return left_ == 0; });
}

void LineWriter::drain_in_signal(std::chrono::milliseconds timeout) const noexcept {
  const timespec millisecond{0, 1'000'000};
  for (auto left = timeout.count(); left > 0 && left_ > 0; --left) nanosleep(&millisecond, nullptr);
}

void LineWriter::run() {
  for (;;) {
    put(next());
    report_dropped();
    const std::lock_guard lock(mutex_);
    if (--left_ == 0) written_.notify_all();
  }
}

std::string LineWriter::next() {
  std::unique_lock lock(mutex_);
  arrived_.wait(lock, [this] { return !lines_.empty(); });
  std::string line = std::move(lines_.front());
  lines_.pop_front();
  bytes_ -= line.size();
  return line;
}

void LineWriter::put(const std::string& line) {
  if (!write_all(fd_, line.data(), line.size())) ++dropped_;
}

// The descriptor has just taken a line, or never will again.
void LineWriter::report_dropped() {
  const uint64_t dropped = dropped_;
  if (dropped == reported_) return;
  const std::string line = report_(dropped - std::exchange(reported_, dropped));
  write_all(fd_, line.data(), line.size());
}

}  // namespace collided::server
