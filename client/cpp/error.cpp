// The one exception of the client library.

#include "client/cpp/error.hpp"

#include <grpcpp/support/status.h>

#include <array>

namespace collided::client {

const char* code_name(int code) {
  constexpr std::array<const char*, 17> kNames{
      "OK",        "CANCELLED",      "UNKNOWN",           "INVALID_ARGUMENT",   "DEADLINE_EXCEEDED",
      "NOT_FOUND", "ALREADY_EXISTS", "PERMISSION_DENIED", "RESOURCE_EXHAUSTED", "FAILED_PRECONDITION",
      "ABORTED",   "OUT_OF_RANGE",   "UNIMPLEMENTED",     "INTERNAL",           "UNAVAILABLE",
      "DATA_LOSS", "UNAUTHENTICATED"};
  return code >= 0 && code < static_cast<int>(kNames.size()) ? kNames[static_cast<size_t>(code)] : "UNKNOWN";
}

Error::Error(int code, const std::string& message, std::string field)
    : std::runtime_error(std::string(code_name(code)) + ": " + message),
      code_(code),
      message_(message),
      field_(std::move(field)) {}

void check(const grpc::Status& status) {
  if (!status.ok()) throw Error(status.error_code(), status.error_message());
}

}  // namespace collided::client
