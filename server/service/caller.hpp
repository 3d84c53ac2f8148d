#pragma once
// Who makes a call, and the ids that its log lines carry.

#include <grpcpp/grpcpp.h>

#include "server/auth/authenticator.hpp"
#include "server/ops/log.hpp"

namespace collided::server {

struct Caller {
  Client client;
  CallIds ids;
};

/// From the call's metadata and certificate. Throws Unauthenticated.
Caller identify(const grpc::ServerContextBase& context, const Authenticator& authenticator);

}  // namespace collided::server
