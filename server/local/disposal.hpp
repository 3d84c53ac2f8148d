#pragma once
// Closing what a client has sent. The kernel may take as long over it as the client likes: a TCP socket lingers, a file
// of FUSE is flushed by the client itself, and a Unix socket can hold more of them on their way. So it is done
// elsewhere.

#include <cstddef>

#include "server/net/fd.hpp"

namespace collided::server {

/// Closes it on a thread that nobody waits for, with what was sent over it and never read.
void close_elsewhere(Fd fd);

/// Descriptors whose closing has begun and not ended.
size_t closing();

/// Whether closing it can take no time: ordinary memory.
bool is_memory(int fd);

/// A file that came over a socket.
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
