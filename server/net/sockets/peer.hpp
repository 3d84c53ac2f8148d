#pragma once
// Who is at the other end of a connection, and how much has come from there.

#include <sys/types.h>

#include <cstdint>
#include <optional>
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

/// Bytes that went over a TCP connection so far.
struct Traffic {
  uint64_t received = 0;      ///< by the kernel
  uint64_t read = 0;          ///< of these, by the connection's owner
  uint64_t sent = 0;          ///< by the kernel, again and again if they are lost
  uint64_t acknowledged = 0;  ///< of these, by the other end
};

/// Of a connection. Nothing if the kernel does not tell, or the connection is none over TCP.
std::optional<Traffic> traffic_of(int socket);

}  // namespace collided::server
