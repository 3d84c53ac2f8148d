#pragma once
// Who is at the other end of a connection, and how much has come from there.

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace collided::server {

struct Peer {
  std::string name;    ///< gRPC's name for it: "ipv4:ADDRESS:PORT", "ipv6:%5BADDRESS%5D:PORT" or "unix:"
  std::string source;  ///< the address without its port, or "uid:NUMBER"
  bool is_unix = false;
};

/// A socket's inode, which is never reused, as its descriptor is; 0 if the descriptor is no socket.
ino_t inode_of(int fd);

/// Of a connected socket. Empty strings if the connection is already closed.
Peer peer_of(int socket);

/// User of the process at the other end of a Unix socket when it connected. Throws std::system_error.
uid_t peer_uid(int socket);

/// Bytes that the kernel has received over a TCP connection so far; 0 if it does not say.
uint64_t received_bytes(int socket);
/// True if bytes have come that the connection's owner has not read.
bool has_unread(int socket);

}  // namespace collided::server
