#pragma once
// A TCP proxy in front of the daemon that can be cut: with a reset, or like a cable, of which neither side is told.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <list>
#include <string>
#include <thread>
#include <vector>

#include "tests/integration/probe.hpp"

namespace collided::test {

class TcpProxy {
 public:
  explicit TcpProxy(std::string target) : target_(std::move(target)), listener_(listen_anywhere()) {
    thread_ = std::thread([this] { run(); });
  }
  TcpProxy(const TcpProxy&) = delete;
  TcpProxy& operator=(const TcpProxy&) = delete;
  ~TcpProxy() {
    state_ = State::kCut;
    is_over_ = true;
    thread_.join();
    close(listener_);
  }

  std::string address() const {
    sockaddr_in bound{};
    socklen_t size = sizeof(bound);
    getsockname(listener_, reinterpret_cast<sockaddr*>(&bound), &size);
    return "127.0.0.1:" + std::to_string(ntohs(bound.sin_port));
  }
  /// Resets the connections, and takes no new ones.
  void cut() { become(State::kCut); }
  /// Nothing gets through any more, in either direction.
  void unplug() { become(State::kUnplugged); }

 private:
  enum class State { kPlugged, kUnplugged, kCut };
  struct Pair {
    int near = -1, far = -1;
  };

  // Returns once nothing of the state before goes on.
  void become(State state) {
    state_ = state;
    while (seen_ != state) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  static int listen_anywhere() {
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    EXPECT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&any), sizeof(any)), 0);
    EXPECT_EQ(listen(listener, 16), 0);
    return listener;
  }

  static void reset(int connection) {
    const linger at_once{1, 0};
    setsockopt(connection, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
    close(connection);
  }

  static void reset(const Pair& pair) {
    reset(pair.near);
    reset(pair.far);
  }

  // False once one side is gone.
  static bool relay(int from, int to) {
    char buffer[65536];
    const ssize_t size = recv(from, buffer, sizeof(buffer), MSG_DONTWAIT);
    if (size < 0) return true;
    for (ssize_t sent = 0, n = 0; sent < size; sent += n)
      if ((n = send(to, buffer + sent, size - sent, MSG_NOSIGNAL)) < 0) return false;
    return size > 0;
  }

  void accept_one() {
    const int near = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (near < 0) return;
    const int far = connect_to(target_);
    if (far < 0) return reset(near);
    pairs_.push_back({near, far});
  }

  void run() {
    while (!is_over_) {
      const State state = state_;
      if (state == State::kCut) close_all();
      seen_ = state;
      if (state == State::kPlugged) {
        step();
      } else {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    }
    close_all();
  }

  void step() {
    std::vector<pollfd> waits = {{listener_, POLLIN, 0}};
    for (const Pair& pair : pairs_)
      for (const int end : {pair.near, pair.far}) waits.push_back({end, POLLIN, 0});
    if (poll(waits.data(), waits.size(), 10) <= 0) return;
    size_t i = 1;
    for (auto pair = pairs_.begin(); pair != pairs_.end(); i += 2) {
      bool open = true;
      if (waits[i].revents) open = relay(pair->near, pair->far);
      if (open && waits[i + 1].revents) open = relay(pair->far, pair->near);
      if (!open) reset(*pair);
      pair = open ? std::next(pair) : pairs_.erase(pair);
    }
    if (waits[0].revents) accept_one();
  }

  void close_all() {
    for (const Pair& pair : pairs_) reset(pair);
    pairs_.clear();
  }

  const std::string target_;
  const int listener_;
  std::list<Pair> pairs_;  // of the thread alone
  std::atomic<State> state_ = State::kPlugged, seen_ = State::kPlugged;
  std::atomic<bool> is_over_ = false;
  std::thread thread_;
};

}  // namespace collided::test
