#pragma once
// Who is at the other end of a connection, and how much has come from there.

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace collided::server {

struct Peer {
  std::string name;    ///< gRPC's name for it: "ipv4:ADDRESS:PORT", "ipv6:%5BADDRESS%5D:PORT" or "unix:"
  std::string source;  ///< the address without its port, or "pid:NUMBER"
  bool is_unix = false;
};

/// Of a connected socket. Empty strings if the connection is already closed.
Peer peer_of(int socket);

/// User of the process at the other end of a Unix socket when it connected. Throws std::system_error.
uid_t peer_uid(int socket);

/// Bytes that the kernel has received on a connection so far, over TCP; 0 if that is not known.
uint64_t received_bytes(int socket);

}  // namespace collided::server
