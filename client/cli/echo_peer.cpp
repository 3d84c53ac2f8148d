// What the sockets alone cost: a child process that takes bytes and gives bytes back.

#include "client/cli/echo_peer.hpp"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <system_error>

namespace collided::cli {

namespace {

/// Bytes that go up after it, and bytes that are to come down.
using Sizes = std::array<size_t, 2>;

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

int checked(int result, const char* what) {
  if (result < 0) fail(what);
  return result;
}

bool send_all(int socket, const char* bytes, size_t size) {
  while (size > 0) {
    const ssize_t sent = send(socket, bytes, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes += sent;
    size -= static_cast<size_t>(sent);
  }
  return true;
}

bool receive_all(int socket, char* bytes, size_t size) {
  while (size > 0) {
    const ssize_t got = recv(socket, bytes, size, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes += got;
    size -= static_cast<size_t>(got);
  }
  return true;
}

bool answer(int socket, std::vector<char>& bytes) {
  Sizes sizes;
  if (!receive_all(socket, reinterpret_cast<char*>(sizes.data()), sizeof sizes)) return false;
  bytes.resize(std::max({bytes.size(), sizes[0], sizes[1]}));
  return receive_all(socket, bytes.data(), sizes[0]) && send_all(socket, bytes.data(), sizes[1]);
}

void no_delay(int socket) {
  const int on = 1;
  checked(setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on), "TCP_NODELAY");
}

/// A connection over loopback TCP.
std::array<int, 2> tcp_pair() {
  const int listener = checked(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), "socket");
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  socklen_t size = sizeof address;
  checked(bind(listener, generic, size), "bind");
  checked(listen(listener, 1), "listen");
  checked(getsockname(listener, generic, &size), "getsockname");
  const int ours = checked(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), "socket");
  checked(connect(ours, generic, size), "connect");
  const int theirs = checked(accept4(listener, nullptr, nullptr, SOCK_CLOEXEC), "accept");
  close(listener);
  no_delay(ours);
  no_delay(theirs);
  return {ours, theirs};
}

/// The child's whole life: until this process closes its ends.
[[noreturn]] void serve(int tcp, int unix_stream) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  std::array<pollfd, 2> sockets{{{tcp, POLLIN, 0}, {unix_stream, POLLIN, 0}}};
  std::vector<char> bytes;
  while (poll(sockets.data(), sockets.size(), -1) >= 0 || errno == EINTR)
    for (const pollfd& socket : sockets)
      if (socket.revents != 0 && !answer(socket.fd, bytes)) _exit(0);
  _exit(1);
}

}  // namespace

EchoPeer::EchoPeer() {
  const std::array<int, 2> tcp = tcp_pair();
  std::array<int, 2> stream;
  checked(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, stream.data()), "socketpair");
  tcp_ = tcp[0];
  unix_ = stream[0];
  pid_ = checked(fork(), "fork");
  if (pid_ == 0) {
    close_sockets();
    serve(tcp[1], stream[1]);
  }
  close(tcp[1]);
  close(stream[1]);
}

EchoPeer::~EchoPeer() {
  close_sockets();
  waitpid(pid_, nullptr, 0);
}

void EchoPeer::close_sockets() {
  close(tcp_);
  close(unix_);
}

double EchoPeer::exchange(int socket, size_t up, size_t down) {
  bytes_.resize(std::max({bytes_.size(), up, down}));
  const Sizes sizes{up, down};
  const auto start = std::chrono::steady_clock::now();
  const bool is_done = send_all(socket, reinterpret_cast<const char*>(sizes.data()), sizeof sizes) &&
                       send_all(socket, bytes_.data(), up) && receive_all(socket, bytes_.data(), down);
  if (!is_done) fail("the echo's socket");
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace collided::cli
