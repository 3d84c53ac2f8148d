// The local socket.
#include "server/local/unix_socket.hpp"

#include <cerrno>
#include <system_error>

namespace collided::server {

uid_t peer_uid(int socket) {
  ucred peer{};
  socklen_t size = sizeof(peer);
  if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0)
    throw std::system_error(errno, std::generic_category(), "SO_PEERCRED");
  return peer.uid;
}

Fd PacketListener::accept() const { return Fd(accept4(socket(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)); }

}  // namespace collided::server
