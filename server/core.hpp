#pragma once
// What serves scenes and calls, whichever way they come in: a daemon's core, or a library's.

#include <cstdint>

#include "server/auth/authenticator.hpp"
#include "server/config/config.hpp"
#include "server/frames/observer.hpp"
#include "server/ops/lifecycle.hpp"
#include "server/ops/metrics.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/service/service.hpp"
#include "server/transport/grpc/rpc_router.hpp"

namespace collided::server {

/// Its parts know each other, and nothing of what is around them.
struct Core {
  /// `lifecycle` must outlive it. Throws ConfigError, and std::runtime_error where the backend cannot be used.
  Core(const Config& config, Lifecycle& lifecycle);
  /// Adds the service, without StreamFrames, the router, and the limits of messages. Before the server is built, which
  /// the core outlives.
  void add_to(grpc::ServerBuilder& builder);

  Metrics metrics;
  Authenticator authenticator;
  ServiceObserver observer;
  SceneHost host;
  CollisionService service;
  RpcRouter router;
  const uint64_t max_message_bytes;  ///< of a received message
};

}  // namespace collided::server
