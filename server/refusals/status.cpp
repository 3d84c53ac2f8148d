// The one table from exceptions to gRPC codes, and google.rpc details.
#include "server/refusals/status.hpp"

#include <absl/status/status.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <system_error>

#include "collided/v1/error_details.pb.h"
#include "gpu/detector.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

namespace pb = collided::v1;
using grpc::StatusCode;

constexpr double kRetrySeconds = 1;  // when the host is temporarily short of something

void pack(const char* name, const google::protobuf::Message& detail, pb::RpcStatus& status) {
  pb::PackedDetail* packed = status.add_details();
  packed->set_type_url(std::string("type.googleapis.com/google.rpc.") + name);
  detail.SerializeToString(packed->mutable_value());
}

pb::RpcStatus details_of(const Failure& failure) {
  pb::RpcStatus status;
  status.set_code(failure.code);
  status.set_message(failure.message);
  if (!failure.field.empty()) {
    pb::BadRequest request;
    auto* violation = request.add_field_violations();
    violation->set_field(failure.field);
    violation->set_description(failure.message);
    pack("BadRequest", request, status);
  }
  if (!failure.subject.empty()) {
    pb::QuotaFailure quota;
    auto* violation = quota.add_violations();
    violation->set_subject(failure.subject);
    violation->set_description(failure.message);
    pack("QuotaFailure", quota, status);
  }
  if (failure.retry_after_seconds > 0) {
    pb::RetryInfo retry;
    const double whole = std::floor(failure.retry_after_seconds);
    retry.mutable_retry_delay()->set_seconds(static_cast<int64_t>(whole));
    retry.mutable_retry_delay()->set_nanos(static_cast<int32_t>((failure.retry_after_seconds - whole) * 1e9));
    pack("RetryInfo", retry, status);
  }
  return status;
}

Failure of_field(StatusCode code, const FieldError& e) { return {code, e.what(), e.field()}; }

// Whether the host has run out of threads, memory, file descriptors or space on a device.
bool is_exhausted(const std::error_code& code) {
  using std::errc;
  const auto all = {errc::resource_unavailable_try_again, errc::not_enough_memory,  errc::too_many_files_open,
                    errc::too_many_files_open_in_system,  errc::no_space_on_device, errc::no_buffer_space};
  return std::any_of(all.begin(), all.end(), [&](errc one) { return code == one; });
}

std::string lacking(const std::error_code& code) {
  if (code == std::errc::resource_unavailable_try_again) return "threads";
  if (code == std::errc::not_enough_memory || code == std::errc::no_buffer_space) return "memory";
  return code == std::errc::no_space_on_device ? "space on a device" : "file descriptors";
}

Failure of_system(const std::system_error& e) {
  if (!is_exhausted(e.code())) return {StatusCode::INTERNAL, e.what()};
  return {StatusCode::RESOURCE_EXHAUSTED, "the daemon is out of " + lacking(e.code()) + ": " + e.what(), "", "daemon",
          kRetrySeconds};
}

}  // namespace

Failure describe(const std::exception_ptr& error) try { std::rethrow_exception(error); } catch (const InvalidInput& e) {
  return {StatusCode::INVALID_ARGUMENT, e.what(), e.field()};
} catch (const NotFound& e) {
  return of_field(StatusCode::NOT_FOUND, e);
} catch (const FailedPrecondition& e) {
  return of_field(StatusCode::FAILED_PRECONDITION, e);
} catch (const AlreadyExists& e) {
  return of_field(StatusCode::ALREADY_EXISTS, e);
} catch (const PermissionDenied& e) {
  return of_field(StatusCode::PERMISSION_DENIED, e);
} catch (const TakenOver& e) {
  return of_field(StatusCode::ABORTED, e);
} catch (const TimedOut& e) {
  return of_field(StatusCode::DEADLINE_EXCEEDED, e);
} catch (const Unimplemented& e) {
  return of_field(StatusCode::UNIMPLEMENTED, e);
} catch (const LimitExceeded& e) {
  return {StatusCode::RESOURCE_EXHAUSTED, e.what(), e.field(), e.subject(), e.retry_after_seconds()};
} catch (const ResourceExhausted& e) {
  return {StatusCode::RESOURCE_EXHAUSTED, e.what(), "", "daemon"};
} catch (const std::bad_alloc&) {
  return {StatusCode::RESOURCE_EXHAUSTED, "the daemon is out of memory", "", "daemon"};
} catch (const Unauthenticated& e) {
  return {StatusCode::UNAUTHENTICATED, e.what()};
} catch (const DeviceError& e) {
  return {StatusCode::UNAVAILABLE, e.what()};
} catch (const DeadlineExceeded& e) {
  return {StatusCode::DEADLINE_EXCEEDED, e.what()};
} catch (const Stopping& e) {
  return {StatusCode::UNAVAILABLE, e.what()};
} catch (const Cancelled& e) {
  return {StatusCode::CANCELLED, e.what()};
} catch (const std::system_error& e) {
  return of_system(e);
} catch (const std::exception& e) {
  return {StatusCode::INTERNAL, e.what()};
} catch (...) {
  return {StatusCode::INTERNAL, "unknown error"};
}

grpc::Status to_status(const Failure& failure) {
  const pb::RpcStatus details = details_of(failure);
  if (details.details().empty()) return {failure.code, failure.message};
  return {failure.code, failure.message, details.SerializeAsString()};
}

std::string code_name(StatusCode code) {
  std::string name = absl::StatusCodeToString(static_cast<absl::StatusCode>(code));
  return name.empty() ? "UNKNOWN" : name;
}

}  // namespace collided::server
