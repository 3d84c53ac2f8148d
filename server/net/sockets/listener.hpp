#pragma once
// The sockets of one address.

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "server/net/sockets/fd.hpp"
#include "server/net/sockets/unix_listener.hpp"

namespace collided::server {

class Listener {
 public:
  /// `address`: host:port (port 0: any free one; listens on every address of the host) or unix:/path. Throws
  /// std::runtime_error, "cannot listen on ADDRESS: why".
  explicit Listener(const std::string& address);

  /// As requested, with the port that the system assigned.
  const std::string& address() const { return address_; }
  bool is_unix() const { return unix_ != nullptr; }
  /// Non-blocking.
  std::vector<int> sockets() const;
  /// Drops TCP connections whose peer takes no data for `timeout`: keepalive pings do not get past a full window.
  /// Applies to new connections.
  void set_user_timeout(std::chrono::milliseconds timeout) const;

 private:
  void listen_on_host(const std::string& host, const std::string& port);

  std::string address_;
  std::unique_ptr<UnixListener> unix_;
  std::vector<Fd> tcp_;
};

}  // namespace collided::server
