#pragma once
// The client library's only exception: a gRPC code, a message and the details that came with them.

#include <optional>
#include <stdexcept>
#include <string>

namespace grpc {
class Status;
}

namespace collided::client {

/// What a refusal says besides its message.
struct ErrorDetails {
  std::string field = "";                          ///< path of the refused field, such as "frame.updates[0].positions"
  std::string quota = "";                          ///< the limit that was reached, its value and what was requested
  std::optional<double> retry_after_seconds = {};  ///< when the same request may succeed
};

/// A request that was refused, or a connection or a daemon that was lost.
class Error : public std::runtime_error {
 public:
  /// `field` is as in ErrorDetails.
  Error(int code, const std::string& message, std::string field = "");
  /// As an answer refuses a request.
  Error(int code, const std::string& message, ErrorDetails details);
  /// A google.rpc.Code, such as 3 for INVALID_ARGUMENT.
  int code() const { return code_; }
  /// The message alone; what() begins with the code's name.
  const std::string& message() const { return message_; }
  /// Path of the refused field; may be empty.
  const std::string& field() const { return details_.field; }
  /// The limit that was reached; may be empty.
  const std::string& quota() const { return details_.quota; }
  /// When the same request may succeed, if waiting helps.
  std::optional<double> retry_after_seconds() const { return details_.retry_after_seconds; }

 private:
  int code_;
  std::string message_;
  ErrorDetails details_;
};

/// Name of a google.rpc.Code, such as "INVALID_ARGUMENT".
std::string code_name(int code);

/// Whether the connection or the daemon was lost (UNAVAILABLE, CANCELLED, INTERNAL) rather than a request refused:
/// reconnect and resume the scene.
bool is_connection_lost(const Error& error);

/// The error of a status with its details; nullopt if it is OK.
std::optional<Error> error_of(const grpc::Status& status);

/// Throws an Error unless the status is OK.
void check(const grpc::Status& status);

}  // namespace collided::client
