#pragma once
// Closes descriptors that clients have sent, on threads that nobody waits for, as the client decides how long it takes:
// a TCP socket lingers, a FUSE file is flushed by the client itself, and a Unix socket can contain more of both.

#include <cstddef>

#include "server/net/sockets/fd.hpp"

namespace collided::server {

/// Closes the descriptor in the background, with what was sent over it and never read.
void close_in_background(Fd fd);

/// Number of descriptors still being closed.
size_t closing();

/// Whether the descriptor is ordinary memory, which closes at once.
bool is_memory(int fd);

/// A file received over a socket.
class PassedFile {
 public:
  explicit PassedFile(int fd = -1) : fd_(fd) {}
  PassedFile(PassedFile&&) noexcept = default;
  PassedFile& operator=(PassedFile&& other) noexcept;
  ~PassedFile();

  const Fd& fd() const { return fd_; }

 private:
  Fd fd_;
};

}  // namespace collided::server
