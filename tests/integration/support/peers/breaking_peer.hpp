#pragma once
// A peer that answers every HTTP/2 call with a reset of its stream, like a connection that breaks within a message.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>
#include <thread>

#include "tests/integration/support/peers/bound_address.hpp"

namespace collided::test {

/// Accepts one connection.
class BreakingPeer {
 public:
  BreakingPeer() : listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(listener_, reinterpret_cast<const sockaddr*>(&any), sizeof(any)), 0);
    EXPECT_EQ(listen(listener_, 1), 0);
    thread_ = std::thread([this] { run(); });
  }
  BreakingPeer(const BreakingPeer&) = delete;
  BreakingPeer& operator=(const BreakingPeer&) = delete;
  ~BreakingPeer() {
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    close(listener_);
  }

  std::string address() const { return address_of(listener_); }

 private:
  using Head = std::array<unsigned char, 9>;  // of a frame: length, type, flags, stream
  static constexpr unsigned char kHeaders = 1, kReset = 3, kSettings = 4, kInternalError = 2;

  static bool read_all(int from, void* to, size_t bytes) {
    return recv(from, to, bytes, MSG_WAITALL) == static_cast<ssize_t>(bytes);
  }

  void run() {
    const int peer = accept(listener_, nullptr, nullptr);
    if (peer < 0) return;
    const Head settings = {0, 0, 0, kSettings};
    send(peer, settings.data(), settings.size(), MSG_NOSIGNAL);
    char preface[24];
    if (read_all(peer, preface, sizeof(preface))) break_calls(peer);
    close(peer);
  }

  static void break_calls(int peer) {
    Head head;
    while (read_all(peer, head.data(), head.size())) {
      std::string rest(size_t{head[0]} << 16 | size_t{head[1]} << 8 | head[2], '\0');
      if (!read_all(peer, rest.data(), rest.size())) return;
      if (head[3] != kHeaders) continue;
      const std::array<unsigned char, 13> reset = {0,       0,       4, kReset, 0, head[5],       head[6],
                                                   head[7], head[8], 0, 0,      0, kInternalError};
      send(peer, reset.data(), reset.size(), MSG_NOSIGNAL);
    }
  }

  int listener_;
  std::thread thread_;
};

}  // namespace collided::test
