#pragma once
// A daemon that can be killed and started again where it was.

#include <optional>

#include "tests/integration/local/local_daemon.hpp"

namespace collided::test {

/// Stops the daemon, until SIGCONT; returns once it runs no more.
inline void pause(const DaemonProcess& daemon) {
  daemon.signal(SIGSTOP);
  siginfo_t stopped{};
  EXPECT_EQ(waitid(P_PID, static_cast<id_t>(daemon.pid()), &stopped, WSTOPPED), 0);
}

class MortalDaemon {
 public:
  MortalDaemon() { start(); }

  std::string address() const { return "unix:" + folder_.file("daemon"); }
  DaemonProcess& process() { return *process_; }
  void start() {
    process_.emplace(std::vector<std::string>{"--address", address(), "--local-socket", folder_.file("local")});
  }
  /// Returns once it runs no more.
  void pause() { test::pause(*process_); }
  void kill() {
    process_->signal(SIGKILL);
    process_->wait();
    process_.reset();
  }

 private:
  OpenFolder folder_;
  std::optional<DaemonProcess> process_;
};

}  // namespace collided::test
