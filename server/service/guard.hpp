#pragma once
// How the unary calls answer: what a body throws becomes the status of its call.

#include <grpcpp/grpcpp.h>

#include "server/service/status.hpp"

namespace collided::server {

/// Runs a body and finishes with what it throws.
template <class Body>
void guard(grpc::ServerUnaryReactor* reactor, const Body& body) {
  try {
    body();
  } catch (...) {
    reactor->Finish(to_status(describe_current()));
  }
}

}  // namespace collided::server
