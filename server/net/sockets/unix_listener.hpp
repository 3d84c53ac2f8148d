#pragma once
// Unix sockets by their paths.

#include <sys/types.h>

#include <optional>
#include <string>

#include "server/net/sockets/fd.hpp"

namespace collided::server {

/// Whether a process has a socket of any type bound to the path. Does not block.
bool is_served(const std::string& path);

/// Listens on a path, and removes it at the end. If several processes want the same path, exactly one gets it.
class UnixListener {
 public:
  struct Options {
    int type = 0;                ///< SOCK_STREAM or SOCK_SEQPACKET
    std::optional<mode_t> mode;  ///< of the socket's file; none: set by the umask
  };

  /// Replaces a stale socket. Throws std::runtime_error ("cannot listen on PATH: why") if the
  /// path is too long, another process serves it, it is another kind of file, or the system refuses.
  UnixListener(const std::string& path, const Options& options);
  ~UnixListener();
  UnixListener(const UnixListener&) = delete;
  UnixListener& operator=(const UnixListener&) = delete;

  /// Non-blocking.
  int socket() const { return socket_.get(); }
  /// The next connection, non-blocking; empty, with errno, if there is none.
  Fd accept() const;

 private:
  void bind_and_listen(const Options& options);

  const std::string path_;
  Fd socket_;
  dev_t device_ = 0;  // with inode_: the file to remove
  ino_t inode_ = 0;
};

}  // namespace collided::server
