#pragma once
// The gRPC server around the service, the local socket and HTTP: addresses, credentials, limits, keepalive, health,
// shutdown.

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "server/builtin/health.hpp"
#include "server/builtin/reflection.hpp"
#include "server/config/config.hpp"
#include "server/core.hpp"
#include "server/entrance.hpp"
#include "server/ops/http_server.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/transport/grpc/frame_calls.hpp"
#include "server/transport/local/local_server.hpp"

namespace collided::server {

class Daemon {
 public:
  /// Binds the addresses and serves. Throws ConfigError, or std::runtime_error with what is wrong. `lifecycle` must
  /// outlive it.
  Daemon(const Config& config, Lifecycle& lifecycle);
  ~Daemon();

  /// Applies the options that may change while the daemon runs. If the tokens file is invalid, throws ConfigError and
  /// changes nothing.
  void reload(const Config& config);

  /// Returns once it has held every lock that calls, frames and health wait for: not at all if one of them is stuck.
  void wait_responsive() const;

  /// Reports NOT_SERVING, refuses new scenes and streams, and tells open streams that they have `grace_seconds`.
  void begin_stop(double grace_seconds);
  /// Waits until no call is open; false after `deadline`.
  bool wait_idle(std::chrono::steady_clock::time_point deadline) const;
  /// Cancels what is left and frees the scenes. Never returns if a client neither reads nor closes a full Unix socket.
  void stop();

  /// With the ports that the system assigned.
  std::vector<std::string> addresses() const { return entrance_.addresses(); }
  /// Of metrics and health; empty if they are off.
  std::string http_address() const { return http_ ? http_->address() : ""; }

 private:
  void listen(const Config& config);
  void abandoned(const std::string& peer);
  void log_devices() const;
  Gauges gauges() const;

  Lifecycle& lifecycle_;
  Core core_;
  Reflection reflection_;
  Health health_;
  Entrance entrance_;
  const CallEvents events_{[this](const grpc::ServerContextBase& call) { entrance_.accepted(call); },
                           [this](const std::string& peer) { abandoned(peer); }};
  std::unique_ptr<LocalServer> local_;
  std::unique_ptr<HttpServer> http_;
  std::unique_ptr<FrameCalls> calls_;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace collided::server
