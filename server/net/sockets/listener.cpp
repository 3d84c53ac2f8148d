// The sockets of one address.
#include "server/net/sockets/listener.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace collided::server {
namespace {

constexpr std::string_view kUnix = "unix:";

[[noreturn]] void throw_cannot(const std::string& address, const std::string& why) {
  throw std::runtime_error("cannot listen on " + address + ": " + why);
}

using AddressList = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

AddressList resolve(const std::string& host, const std::string& port, const std::string& address) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  if (error != 0) throw_cannot(address, gai_strerror(error));
  return {found, freeaddrinfo};
}

in_port_t& port_of(sockaddr* address) {
  return address->sa_family == AF_INET6 ? reinterpret_cast<sockaddr_in6*>(address)->sin6_port
                                        : reinterpret_cast<sockaddr_in*>(address)->sin_port;
}

unsigned bound_port(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(port_of(reinterpret_cast<sockaddr*>(&address)));
}

void set(int socket, int level, int name, int value) { setsockopt(socket, level, name, &value, sizeof(value)); }

// Empty, with errno, if the system refuses.
Fd listen_on(const addrinfo& to) {
  Fd socket(::socket(to.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return socket;
  set(socket.get(), SOL_SOCKET, SO_REUSEADDR, 1);
  set(socket.get(), IPPROTO_TCP, TCP_NODELAY, 1);  // connections inherit it
  // [::] accepts IPv4, too; localhost and names have a separate socket for it.
  const auto& v6 = *reinterpret_cast<const sockaddr_in6*>(to.ai_addr);
  if (to.ai_family == AF_INET6)
    set(socket.get(), IPPROTO_IPV6, IPV6_V6ONLY, IN6_IS_ADDR_UNSPECIFIED(&v6.sin6_addr) ? 0 : 1);
  const bool listens = bind(socket.get(), to.ai_addr, to.ai_addrlen) == 0 && listen(socket.get(), SOMAXCONN) == 0;
  return listens ? std::move(socket) : Fd();
}

std::string without_brackets(const std::string& host) {
  return host.starts_with('[') && host.ends_with(']') ? host.substr(1, host.size() - 2) : host;
}

}  // namespace

Listener::Listener(const std::string& address) : address_(address) {
  if (address.starts_with(kUnix)) {
    unix_ = std::make_unique<UnixListener>(address.substr(kUnix.size()), UnixListener::Options{SOCK_STREAM, {}});
    return;
  }
  const auto colon = address.rfind(':');
  listen_on_host(without_brackets(address.substr(0, colon)), address.substr(colon + 1));
  address_ = address.substr(0, colon + 1) + std::to_string(bound_port(tcp_.front().get()));
}

// Listens on all of the host's addresses that this machine has; if it has none, the last failure is the reason.
void Listener::listen_on_host(const std::string& host, const std::string& port) {
  const AddressList found = resolve(host, port, address_);
  int error = 0;
  for (const addrinfo* to = found.get(); to; to = to->ai_next) {
    if (!tcp_.empty()) port_of(to->ai_addr) = htons(static_cast<uint16_t>(bound_port(tcp_.front().get())));
    Fd socket = listen_on(*to);
    if (socket)
      tcp_.push_back(std::move(socket));
    else if (errno != EAFNOSUPPORT && errno != EADDRNOTAVAIL)
      throw_cannot(address_, std::strerror(errno));
    else
      error = errno;
  }
  if (tcp_.empty()) throw_cannot(address_, std::strerror(error));
}

// Connections inherit it.
void Listener::set_user_timeout(std::chrono::milliseconds timeout) const {
  for (const auto& socket : tcp_) set(socket.get(), IPPROTO_TCP, TCP_USER_TIMEOUT, static_cast<int>(timeout.count()));
}

std::vector<int> Listener::sockets() const {
  if (unix_) return {unix_->socket()};
  std::vector<int> sockets;
  for (const auto& socket : tcp_) sockets.push_back(socket.get());
  return sockets;
}

}  // namespace collided::server
