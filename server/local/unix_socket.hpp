#pragma once
// Unix sockets by their paths: who listens, and who is at the other end.

#include <sys/types.h>

#include <string>

#include "server/local/fd.hpp"

namespace collided::server {

/// Whether a process has a socket of any type bound to the path. Does not wait.
bool is_served(const std::string& path);

/// User of the process at the other end, as it was when that connected. Throws std::system_error.
uid_t peer_uid(int socket);

/// Listens on a path for connections of packets (SOCK_SEQPACKET), and removes the path at its end.
class PacketListener {
 public:
  /// `mode`: of the socket's file. Takes the place of a socket that nobody serves. Throws std::runtime_error if the
  /// path is too long, another process serves there, another kind of file is there, or the system refuses.
  PacketListener(const std::string& path, mode_t mode);
  ~PacketListener();
  PacketListener(const PacketListener&) = delete;
  PacketListener& operator=(const PacketListener&) = delete;

  int socket() const { return socket_.get(); }
  /// The next connection, which does not block; none (and errno) if there is none.
  Fd accept() const;

 private:
  std::string path_;
  Fd socket_;
  dev_t device_ = 0;  // with inode_: the file that is ours to remove
  ino_t inode_ = 0;
};

}  // namespace collided::server
