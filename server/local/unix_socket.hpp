#pragma once
// The local socket: connections of packets, and who is at their other end.

#include <sys/socket.h>
#include <sys/types.h>

#include <string>

#include "server/net/unix_listener.hpp"

namespace collided::server {

/// User of the process at the other end, as it was when that connected. Throws std::system_error.
uid_t peer_uid(int socket);

/// Listens on a path for connections of packets (SOCK_SEQPACKET), and removes the path at its end.
class PacketListener {
 public:
  /// `mode`: of the socket's file. Throws as UnixListener.
  PacketListener(const std::string& path, mode_t mode) : listener_(path, {SOCK_SEQPACKET, mode}) {}

  int socket() const { return listener_.socket(); }
  /// The next connection, which does not block; none (and errno) if there is none.
  Fd accept() const;

 private:
  UnixListener listener_;
};

}  // namespace collided::server
