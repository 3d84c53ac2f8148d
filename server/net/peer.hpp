#pragma once
// Who is at the other end of a connection.

#include <string>

namespace collided::server {

struct Peer {
  std::string name;    ///< as gRPC names it: "ipv4:ADDRESS:PORT", "ipv6:%5BADDRESS%5D:PORT" or "unix:"
  std::string source;  ///< the address without its port, or "pid:NUMBER"
  bool is_unix = false;
};

/// Of a connected socket. Empty texts if the connection is already gone.
Peer peer_of(int socket);

}  // namespace collided::server
