// Who is at the other end of a connection.
#include "server/net/sockets/peer.hpp"

#include <arpa/inet.h>
#include <linux/sockios.h>
#include <linux/tcp.h>  // the C library's tcp_info ends before the count of bytes
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <system_error>

namespace collided::server {
namespace {

Peer of_process(int socket) {
  ucred process{};
  socklen_t size = sizeof(process);
  getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &process, &size);
  return {"unix:", "pid:" + std::to_string(process.pid), true};
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

Peer peer_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  if (getpeername(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  if (address.ss_family == AF_UNIX) return of_process(socket);
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

std::optional<Traffic> traffic_of(int socket) {
  tcp_info info{};
  socklen_t size = sizeof(info);
  constexpr size_t kEnd = offsetof(tcp_info, tcpi_bytes_sent) + sizeof(info.tcpi_bytes_sent);
  if (getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) != 0 || size < kEnd) return {};
  int unread = 0;
  if (ioctl(socket, SIOCINQ, &unread) != 0) return {};
  const uint64_t received = info.tcpi_bytes_received, waiting = std::min<uint64_t>(unread, received);
  return Traffic{received, received - waiting, info.tcpi_bytes_sent, info.tcpi_bytes_acked};
}

}  // namespace collided::server
