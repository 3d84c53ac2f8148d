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

  /// As it was asked for, with the port that was given out.
  const std::string& address() const { return address_; }
  bool is_unix() const { return unix_ != nullptr; }
  /// They do not block.
  std::vector<int> sockets() const;
  /// Drops connections of TCP whose other end takes nothing for so long: no ping gets past a full window. Of those
  /// that come from now on.
  void set_patience(std::chrono::milliseconds patience) const;

 private:
  void listen_on_host(const std::string& host, const std::string& port);

  std::string address_;
  std::unique_ptr<UnixListener> unix_;
  std::vector<Fd> tcp_;
};

}  // namespace collided::server
