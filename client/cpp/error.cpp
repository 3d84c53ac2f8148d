// The client library's only exception.

#include "client/cpp/error.hpp"

#include <absl/status/status.h>
#include <grpcpp/support/status.h>

#include "collided/v1/error_details.pb.h"

namespace collided::client {

namespace {

template <class T>
bool unpack(const v1::PackedDetail& detail, const char* name, T& out) {
  return detail.type_url().ends_with(std::string("/google.rpc.") + name) && out.ParseFromString(detail.value());
}

/// From the bytes of `grpc-status-details-bin`; anything else has no details.
ErrorDetails details_of(const std::string& bytes) {
  ErrorDetails out;
  v1::RpcStatus status;
  if (!status.ParseFromString(bytes)) return out;
  for (const v1::PackedDetail& detail : status.details()) {
    v1::BadRequest bad;
    v1::QuotaFailure quota;
    v1::RetryInfo retry;
    if (unpack(detail, "BadRequest", bad) && bad.field_violations_size() > 0)
      out.field = bad.field_violations(0).field();
    if (unpack(detail, "QuotaFailure", quota) && quota.violations_size() > 0)
      out.quota = quota.violations(0).subject() + ": " + quota.violations(0).description();
    if (unpack(detail, "RetryInfo", retry))
      out.retry_after_seconds = static_cast<double>(retry.retry_delay().seconds()) + retry.retry_delay().nanos() * 1e-9;
  }
  return out;
}

/// gRPC refuses what is far above the daemon's limit by itself, and does not know which option sets it.
std::string naming_option(const std::string& message) {
  const bool is_of_grpc = message.starts_with("Received message larger than max");
  return is_of_grpc ? message + " (the daemon's option max-message-mb)" : message;
}

}  // namespace

std::string code_name(int code) {
  std::string name = absl::StatusCodeToString(static_cast<absl::StatusCode>(code));
  return name.empty() ? "UNKNOWN" : name;
}

Error::Error(int code, const std::string& message, std::string field)
    : Error(code, message, ErrorDetails{.field = std::move(field)}) {}

Error::Error(int code, const std::string& message, ErrorDetails details)
    : std::runtime_error(code_name(code) + ": " + message),
      code_(code),
      message_(message),
      details_(std::move(details)) {}

bool is_connection_lost(const Error& error) {
  return error.code() == grpc::UNAVAILABLE || error.code() == grpc::CANCELLED || error.code() == grpc::INTERNAL;
}

std::optional<Error> error_of(const grpc::Status& status) {
  if (status.ok()) return std::nullopt;
  return Error(status.error_code(), naming_option(status.error_message()), details_of(status.error_details()));
}

void check(const grpc::Status& status) {
  if (const auto error = error_of(status)) throw *error;
}

}  // namespace collided::client
