#pragma once
// The sockets of one address.

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "server/net/fd.hpp"
#include "server/net/unix_listener.hpp"

namespace collided::server {

class Listener {
 public:
  /// `address`: host:port (port 0: any free one; every address of the host is listened on) or unix:/path. Throws
  /// std::runtime_error, "cannot listen on ADDRESS: why".
  explicit Listener(const std::string& address);

  /// As it was asked for, with the port that the system assigned.
  const std::string& address() const { return address_; }
  bool is_unix() const { return unix_ != nullptr; }
  /// Non-blocking.
  std::vector<int> sockets() const;
  /// Drops TCP connections whose peer takes nothing for so long: no ping gets past a full window. For connections from
  /// now on.
  void set_user_timeout(std::chrono::milliseconds timeout) const;

 private:
  void listen_on_host(const std::string& host, const std::string& port);

  std::string address_;
  std::unique_ptr<UnixListener> unix_;
  std::vector<Fd> tcp_;
};

}  // namespace collided::server
