// The one table from exceptions to gRPC codes, and google.rpc.BadRequest details.
#include "server/service/status.hpp"

#include <cstdint>
#include <new>
#include <string_view>

#include "gpu/detector.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

using grpc::StatusCode;

void put_varint(std::string& out, uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<char>(value | 0x80));
  out.push_back(static_cast<char>(value));
}

void put_bytes(std::string& out, uint32_t number, std::string_view bytes) {
  put_varint(out, number << 3 | 2);
  put_varint(out, bytes.size());
  out.append(bytes);
}

// google.rpc.BadRequest { repeated FieldViolation { string field = 1; string description = 2; } = 1; }
std::string bad_request(const Failure& failure) {
  std::string violation, out;
  put_bytes(violation, 1, failure.field);
  put_bytes(violation, 2, failure.message);
  put_bytes(out, 1, violation);
  return out;
}

// google.rpc.Status { int32 code = 1; string message = 2; repeated google.protobuf.Any details = 3; }.
// Written by hand: Debian packages no googleapis, and these three messages are all that is needed.
std::string rpc_status(const Failure& failure) {
  std::string any, out;
  put_bytes(any, 1, "type.googleapis.com/google.rpc.BadRequest");
  put_bytes(any, 2, bad_request(failure));
  put_varint(out, 1 << 3);
  put_varint(out, static_cast<uint64_t>(failure.code));
  put_bytes(out, 2, failure.message);
  put_bytes(out, 3, any);
  return out;
}

}  // namespace

Failure describe(const std::exception_ptr& error) try { std::rethrow_exception(error); } catch (const InvalidInput& e) {
  return {StatusCode::INVALID_ARGUMENT, e.what(), e.field()};
} catch (const NotFound& e) {
  return {StatusCode::NOT_FOUND, e.what(), e.field()};
} catch (const FailedPrecondition& e) {
  return {StatusCode::FAILED_PRECONDITION, e.what(), e.field()};
} catch (const Unimplemented& e) {
  return {StatusCode::UNIMPLEMENTED, e.what(), e.field()};
} catch (const LimitExceeded& e) {
  return {StatusCode::RESOURCE_EXHAUSTED, e.what(), e.field()};
} catch (const ResourceExhausted& e) {
  return {StatusCode::RESOURCE_EXHAUSTED, e.what(), ""};
} catch (const std::bad_alloc&) {
  return {StatusCode::RESOURCE_EXHAUSTED, "the daemon is out of memory", ""};
} catch (const DeviceError& e) {
  return {StatusCode::UNAVAILABLE, e.what(), ""};
} catch (const Stopping& e) {
  return {StatusCode::UNAVAILABLE, e.what(), ""};
} catch (const Cancelled& e) {
  return {StatusCode::CANCELLED, e.what(), ""};
} catch (const std::exception& e) {
  return {StatusCode::INTERNAL, e.what(), ""};
} catch (...) {
  return {StatusCode::INTERNAL, "unknown error", ""};
}

grpc::Status to_status(const Failure& failure) {
  if (failure.field.empty()) return {failure.code, failure.message};
  return {failure.code, failure.message, rpc_status(failure)};
}

bool ends_stream(const Failure& failure) {
  return failure.code == StatusCode::NOT_FOUND || failure.code == StatusCode::UNAVAILABLE ||
         failure.code == StatusCode::CANCELLED;
}

}  // namespace collided::server
