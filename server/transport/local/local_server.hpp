#pragma once
// The Unix socket for clients on the daemon's host (collided/v1/local.proto): accepts connections, and ends them.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/net/sockets/unix_listener.hpp"
#include "server/transport/local/connection.hpp"

namespace collided::server {

struct LocalOptions {
  std::string path;
  std::vector<uint32_t> allowed_uids;  ///< besides the daemon's own
  bool cuda_ipc = false;               ///< accept device memory of clients
  LocalTimeouts timeouts;
};

class LocalServer {
 public:
  /// Listens and serves. The references must outlive it. Throws std::runtime_error if it cannot.
  LocalServer(const LocalOptions& options, SceneHost& host, const Authenticator& authenticator, Metrics& metrics);
  ~LocalServer();
  LocalServer(const LocalServer&) = delete;
  LocalServer& operator=(const LocalServer&) = delete;

  /// Ends all streams (UNAVAILABLE) within a second, and removes the socket. The scenes must still exist.
  void stop();
  /// Ends the connections whose stream is not open: the daemon is about to stop.
  void announce_stop();
  const std::string& path() const { return options_.path; }
  /// Number of connections, with or without an open stream.
  size_t connections() const;
  /// Bytes of answers that clients have not taken.
  uint64_t outgoing_bytes() const;

 private:
  struct Served {
    std::shared_ptr<Connection> connection;
    std::thread thread;
    std::atomic<bool> is_over = false;
  };

  void run();
  void take_connections();
  void check_peer(int socket) const;
  bool evict_silent();
  void check_connections();
  void serve(Fd socket);
  void begin_thread(const std::shared_ptr<Connection>& connection);
  void join_ended();
  void wake() const;

  const LocalOptions options_;
  Metrics& metrics_;
  const OpeningRules rules_;
  std::unique_ptr<UnixListener> listener_;
  Fd wake_;
  std::atomic<bool> is_stopping_ = false;
  mutable std::mutex mutex_;
  std::list<Served> served_;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace collided::server
