#pragma once
// The one exception of the client library: a gRPC code, its message and, where a frame was refused, the field.

#include <stdexcept>
#include <string>

namespace grpc {
class Status;
}

namespace collided::client {

class Error : public std::runtime_error {
 public:
  Error(int code, const std::string& message, std::string field = "");
  /// google.rpc.Code, such as 3 for INVALID_ARGUMENT.
  int code() const { return code_; }
  /// The message alone; what() has the code's name before it.
  const std::string& message() const { return message_; }
  const std::string& field() const { return field_; }

 private:
  int code_;
  std::string message_;
  std::string field_;
};

/// Name of a google.rpc.Code, such as "INVALID_ARGUMENT".
const char* code_name(int code);

/// Throws an Error unless the status is OK.
void check(const grpc::Status& status);

}  // namespace collided::client
