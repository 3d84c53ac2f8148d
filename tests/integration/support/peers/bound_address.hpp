#pragma once
// The address of a test peer.

#include <arpa/inet.h>
#include <sys/socket.h>

#include <string>

namespace collided::test {

/// host:port of a TCP socket that is bound on this machine.
inline std::string address_of(int socket) {
  sockaddr_in bound{};
  socklen_t size = sizeof(bound);
  getsockname(socket, reinterpret_cast<sockaddr*>(&bound), &size);
  return "127.0.0.1:" + std::to_string(ntohs(bound.sin_port));
}

}  // namespace collided::test
