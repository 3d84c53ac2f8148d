#pragma once
// The one table from exceptions to gRPC codes, and google.rpc.BadRequest details.

#include <grpcpp/support/status.h>

#include <exception>
#include <string>

namespace collided::server {

/// What a caller is told about an exception.
struct Failure {
  grpc::StatusCode code = grpc::StatusCode::OK;
  std::string message;
  std::string field;  ///< path of the field; may be empty
};

Failure describe(const std::exception_ptr& error);

/// The exception being handled.
inline Failure describe_current() { return describe(std::current_exception()); }

/// Status with a serialized google.rpc.Status as its details, holding a BadRequest if a field is named.
grpc::Status to_status(const Failure& failure);

/// Whether a failed frame ends its stream: the scene or the device is gone, or the caller is.
bool ends_stream(const Failure& failure);

}  // namespace collided::server
