#pragma once
// Who makes a call, and the ids for its log lines.

#include <grpcpp/grpcpp.h>

#include <map>
#include <string>

#include "server/auth/authenticator.hpp"
#include "server/ops/log.hpp"

namespace collided::server {

struct Caller {
  Client client;
  CallIds ids;
};

/// The ids in a call's metadata.
CallIds ids_of(const std::multimap<grpc::string_ref, grpc::string_ref>& metadata);

/// The peer, as gRPC names it, without its port: the same for all connections of a host.
inline std::string source_of(const std::string& peer) { return peer.substr(0, peer.rfind(':')); }

/// From the call's metadata and certificate. Throws Unauthenticated.
Caller identify(const grpc::ServerContextBase& context, const Authenticator& authenticator);

}  // namespace collided::server
