// Who is at the other end of a connection.
#include "server/net/sockets/peer.hpp"

#include <arpa/inet.h>
#include <linux/sockios.h>
#include <linux/tcp.h>  // the C library's tcp_info ends before the count of bytes
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <system_error>

namespace collided::server {
namespace {

Peer of_user(int socket) {
  ucred process{};
  socklen_t size = sizeof(process);
  getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &process, &size);
  return {"unix:", "uid:" + std::to_string(process.uid), true};
}

Peer of_v4(const in_addr& address, in_port_t port) {
  char text[INET_ADDRSTRLEN] = {};
  inet_ntop(AF_INET, &address, text, sizeof(text));
  return {std::string("ipv4:") + text + ":" + std::to_string(ntohs(port)), text};
}

Peer of_v6(const sockaddr_in6& address) {
  if (IN6_IS_ADDR_V4MAPPED(&address.sin6_addr)) {
    in_addr v4{};
    std::memcpy(&v4, address.sin6_addr.s6_addr + 12, sizeof(v4));
    return of_v4(v4, address.sin6_port);
  }
  char text[INET6_ADDRSTRLEN] = {};
  inet_ntop(AF_INET6, &address.sin6_addr, text, sizeof(text));
  const std::string scope = address.sin6_scope_id ? "%25" + std::to_string(address.sin6_scope_id) : "";
  return {std::string("ipv6:%5B") + text + scope + "%5D:" + std::to_string(ntohs(address.sin6_port)), text};
}

}  // namespace

ino_t inode_of(int fd) {
  struct stat file {};
  return fstat(fd, &file) == 0 && S_ISSOCK(file.st_mode) ? file.st_ino : 0;
}

Peer peer_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  if (getpeername(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  if (address.ss_family == AF_UNIX) return of_user(socket);
  if (address.ss_family == AF_INET6) return of_v6(reinterpret_cast<const sockaddr_in6&>(address));
  const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
  return of_v4(v4.sin_addr, v4.sin_port);
}

uid_t peer_uid(int socket) {
  ucred peer{};
  socklen_t size = sizeof(peer);
  if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0)
    throw std::system_error(errno, std::generic_category(), "SO_PEERCRED");
  return peer.uid;
}

uint64_t received_bytes(int socket) {
  tcp_info info{};
  socklen_t size = sizeof(info);
  constexpr size_t kEnd = offsetof(tcp_info, tcpi_bytes_received) + sizeof(info.tcpi_bytes_received);
  const bool is_told = getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 && size >= kEnd;
  return is_told ? info.tcpi_bytes_received : 0;
}

bool has_unread(int socket) {
  int unread = 0;
  return ioctl(socket, SIOCINQ, &unread) == 0 && unread > 0;
}

}  // namespace collided::server
