#pragma once
// The one table from exceptions to gRPC codes, and google.rpc details.

#include <grpcpp/support/status.h>

#include <exception>
#include <string>

namespace collided::server {

/// What to tell the caller about an exception.
struct Failure {
  grpc::StatusCode code = grpc::StatusCode::OK;
  std::string message;
  std::string field = {};          ///< path of the field; may be empty
  std::string subject = {};        ///< of the limit that was reached, such as "client:NAME"; may be empty
  double retry_after_seconds = 0;  ///< 0: the same request would fail again
};

Failure describe(const std::exception_ptr& error);

/// The exception being handled.
inline Failure describe_current() { return describe(std::current_exception()); }

/// Status whose details are a serialized RpcStatus (error_details.proto) with what is known of the failure.
grpc::Status to_status(const Failure& failure);

/// Name of a code, such as "NOT_FOUND".
std::string code_name(grpc::StatusCode code);

}  // namespace collided::server
