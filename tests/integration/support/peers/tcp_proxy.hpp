#pragma once
// A TCP proxy in front of the daemon that can be cut: with a reset, or like a cable, which neither side notices.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <list>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/integration/support/peers/bound_address.hpp"
#include "tests/integration/support/probe.hpp"

namespace collided::test {

class TcpProxy {
 public:
  /// Sees what goes from a client to the daemon: of which connection, from 0, and the bytes. On the proxy's thread.
  using Watch = std::function<void(size_t connection, std::string_view bytes)>;

  explicit TcpProxy(std::string target, Watch watch = {})
      : target_(std::move(target)), watch_(std::move(watch)), listener_(listen_anywhere()) {
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

  std::string address() const { return address_of(listener_); }
  /// Resets the connections, and accepts no new ones.
  void cut() { become(State::kCut); }
  /// Nothing gets through from now on, in either direction.
  void unplug() { become(State::kUnplugged); }
  /// Everything gets through again.
  void plug() { become(State::kPlugged); }

 private:
  enum class State { kPlugged, kUnplugged, kCut };
  struct Pair {
    int near = -1, far = -1;
    size_t number = 0;
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
  template <class Look>
  static bool relay(int from, int to, const Look& look) {
    char buffer[65536];
    const ssize_t size = recv(from, buffer, sizeof(buffer), MSG_DONTWAIT);
    if (size < 0) return true;
    look(std::string_view(buffer, static_cast<size_t>(size)));
    for (ssize_t sent = 0, n = 0; sent < size; sent += n)
      if ((n = send(to, buffer + sent, size - sent, MSG_NOSIGNAL)) < 0) return false;
    return size > 0;
  }

  void accept_one() {
    const int near = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (near < 0) return;
    const int far = connect_to(target_);
    if (far < 0) return reset(near);
    pairs_.push_back({near, far, accepted_++});
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
      const auto watch = [&](std::string_view bytes) {
        if (watch_) watch_(pair->number, bytes);
      };
      if (waits[i].revents) open = relay(pair->near, pair->far, watch);
      if (open && waits[i + 1].revents) open = relay(pair->far, pair->near, [](std::string_view) {});
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
  const Watch watch_;
  const int listener_;
  std::list<Pair> pairs_;  // owned by the thread
  size_t accepted_ = 0;    // the same
  std::atomic<State> state_ = State::kPlugged, seen_ = State::kPlugged;
  std::atomic<bool> is_over_ = false;
  std::thread thread_;
};

}  // namespace collided::test
