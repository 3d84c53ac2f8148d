#pragma once
// The gRPC server around the service: addresses, limits, keepalive, health, reflection, stop.

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>
#include <vector>

#include "server/config/config.hpp"

namespace collided::server {

class CollisionService;

class Daemon {
 public:
  /// Binds the addresses and serves. Throws std::runtime_error with what is wrong.
  explicit Daemon(const Config& config);
  ~Daemon();

  /// Tells the streams, waits for calls in flight at most `grace_seconds`, frees the scenes.
  void stop(double grace_seconds);
  /// With the ports that were given out.
  const std::vector<std::string>& addresses() const { return addresses_; }

 private:
  std::unique_ptr<CollisionService> service_;
  std::unique_ptr<grpc::Server> server_;
  std::vector<std::string> addresses_;
};

}  // namespace collided::server
