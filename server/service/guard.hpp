#pragma once
// How the unary calls answer: what a body throws becomes the status of its call.

#include <grpcpp/grpcpp.h>

#include "server/ops/log.hpp"
#include "server/service/status.hpp"

namespace collided::server {

/// Runs a body and finishes with what it throws.
template <class Body>
void guard(grpc::ServerUnaryReactor* reactor, const Body& body) {
  try {
    body();
  } catch (...) {
    const Failure failure = describe_current();
    log_event(spdlog::level::info, "call refused", {{"code", code_name(failure.code)}, {"reason", failure.message}});
    reactor->Finish(to_status(failure));
  }
}

}  // namespace collided::server
