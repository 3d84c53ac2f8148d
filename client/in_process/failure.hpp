#pragma once
// The server's exceptions as the client's.

#include "client/cpp/error.hpp"
#include "server/in_process.hpp"

namespace collided::client {

/// Calls, and throws what a call over gRPC would have thrown.
template <class Call>
auto as_errors(const Call& call) {
  try {
    return call();
  } catch (const Error&) {
    throw;
  } catch (...) {
    throw *error_of(server::to_status(server::describe_current()));
  }
}

}  // namespace collided::client
