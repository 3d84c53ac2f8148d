// Measures the cost of sockets alone: a child process that receives bytes and sends bytes back.

#include "client/measure/end_to_end/echo_peer.hpp"

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
#include <cstring>
#include <system_error>
#include <thread>

namespace collided::cli {

namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

constexpr size_t kHead = sizeof(double);  // of an answer: the peer's sleep in milliseconds

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
  Exchange what;
  if (!receive_all(socket, reinterpret_cast<char*>(&what), sizeof what)) return false;
  bytes.resize(std::max({bytes.size(), what.up, kHead + what.down}));
  if (!receive_all(socket, bytes.data(), what.up)) return false;
  const auto begin = Clock::now();
  if (what.hold_ms > 0) std::this_thread::sleep_until(begin + Milliseconds(what.hold_ms));
  const double slept = Milliseconds(Clock::now() - begin).count();
  std::memcpy(bytes.data(), &slept, kHead);
  return send_all(socket, bytes.data(), kHead + what.down);
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

/// The child's main loop, until the parent closes its sockets.
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

double EchoPeer::exchange(int socket, const Exchange& what) {
  bytes_.resize(std::max({bytes_.size(), what.up, kHead + what.down}));
  const auto start = Clock::now();
  const bool is_done = send_all(socket, reinterpret_cast<const char*>(&what), sizeof what) &&
                       send_all(socket, bytes_.data(), what.up) &&
                       receive_all(socket, bytes_.data(), kHead + what.down);
  const double ms = Milliseconds(Clock::now() - start).count();
  if (!is_done) fail("the echo's socket");
  double slept = 0;
  std::memcpy(&slept, bytes_.data(), kHead);
  return ms - slept;
}

}  // namespace collided::cli
