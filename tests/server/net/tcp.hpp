#pragma once
// TCP connections of this process to itself.

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <chrono>
#include <string>
#include <thread>

#include "server/net/sockets/listener.hpp"

namespace collided::server {

inline Fd connect_to(const Listener& listener) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(static_cast<uint16_t>(std::stoi(listener.address().substr(listener.address().rfind(':') + 1))));
  Fd client(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  EXPECT_EQ(connect(client.get(), reinterpret_cast<const sockaddr*>(&to), sizeof(to)), 0);
  return client;
}

/// Both ends of a connection.
struct Pair {
  explicit Pair(const Listener& listener) : client(connect_to(listener)) {
    pollfd state{listener.sockets().front(), POLLIN, 0};
    poll(&state, 1, 20'000);
    server = Fd(accept4(state.fd, nullptr, nullptr, SOCK_CLOEXEC));
    EXPECT_TRUE(server);
  }
  /// Whether the server's end was shut down.
  bool is_ended() const {
    char byte;
    return recv(client.get(), &byte, 1, MSG_DONTWAIT) == 0;
  }

  Fd client, server;
};

/// Waits until it holds; false after 20 s.
template <class Condition>
bool eventually(const Condition& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace collided::server
