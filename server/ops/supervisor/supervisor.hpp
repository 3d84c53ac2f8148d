#pragma once
// What the daemon tells the service manager that started it: ready, reloading, stopping, alive.

#include <chrono>
#include <string>
#include <vector>

namespace collided::server {

/// Not thread-safe: main's own. Without a service manager ($NOTIFY_SOCKET) it does nothing.
class Supervisor {
 public:
  Supervisor();

  /// The start takes as long as `seconds` from now on: the service manager waits for that. `status`: what it waits for.
  void starting(double seconds, const std::string& status);
  /// The daemon serves on `addresses`.
  void ready(const std::vector<std::string>& addresses);
  /// The configuration is being read again.
  void reloading();
  /// It has been read; or it was refused because of `problem`, and the previous one stays in effect.
  void reloaded(const std::string& problem);
  /// The daemon stops, within `seconds`: the service manager waits at least as long before it kills.
  void stopping(double seconds);

  /// Whether the service manager restarts a daemon that is not alive().
  bool watches() const { return timeout_.count() > 0; }
  /// Between two calls of alive(); a long time if nobody watches.
  std::chrono::microseconds alive_interval() const;
  /// The daemon is not stuck. May be called more often than the service manager wants to hear it.
  void alive();

 private:
  std::chrono::microseconds timeout_;
  std::chrono::steady_clock::time_point next_{};
  std::string serves_;
};

}  // namespace collided::server
