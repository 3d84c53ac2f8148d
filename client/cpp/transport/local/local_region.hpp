#pragma once
// Memory that a client shares with the daemon on its host: a sealed memfd.

#include <cstddef>
#include <cstdint>
#include <span>

namespace collided::client {

/// A file descriptor that closes itself.
class LocalFd {
 public:
  explicit LocalFd(int fd = -1) : fd_(fd) {}
  LocalFd(LocalFd&& other) noexcept;
  LocalFd& operator=(LocalFd&& other) noexcept;
  ~LocalFd();
  int get() const { return fd_; }

 private:
  int fd_;
};

class LocalRegion {
 public:
  /// Neither side can shrink or grow it. Pages are allocated on first touch. Throws Error (RESOURCE_EXHAUSTED).
  explicit LocalRegion(uint64_t bytes);
  ~LocalRegion();
  LocalRegion(const LocalRegion&) = delete;
  LocalRegion& operator=(const LocalRegion&) = delete;

  std::span<std::byte> bytes() const { return bytes_; }
  /// The descriptor to hand over; -1 if there are no bytes.
  int file() const { return file_.get(); }

 private:
  LocalFd file_;
  std::span<std::byte> bytes_;
};

}  // namespace collided::client
