// The table from exceptions to gRPC codes, and its details on the wire.
#include "server/refusals/status.hpp"

#include <gtest/gtest.h>

#include <new>
#include <system_error>

#include "collided/v1/error_details.pb.h"
#include "gpu/detector.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

namespace pb = collided::v1;

template <class Error>
Failure describe_as(const Error& error) {
  return describe(std::make_exception_ptr(error));
}

TEST(Status, MapsEveryException) {
  using grpc::StatusCode;
  EXPECT_EQ(describe_as(InvalidInput("f", "m")).code, StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(describe_as(NotFound("f", "m")).code, StatusCode::NOT_FOUND);
  EXPECT_EQ(describe_as(FailedPrecondition("f", "m")).code, StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(describe_as(AlreadyExists("f", "m")).code, StatusCode::ALREADY_EXISTS);
  EXPECT_EQ(describe_as(PermissionDenied("f", "m")).code, StatusCode::PERMISSION_DENIED);
  EXPECT_EQ(describe_as(TakenOver("f", "m")).code, StatusCode::ABORTED);
  EXPECT_EQ(describe_as(TimedOut("f", "m")).code, StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(describe_as(Unauthenticated("m")).code, StatusCode::UNAUTHENTICATED);
  EXPECT_EQ(describe_as(Unimplemented("f", "m")).code, StatusCode::UNIMPLEMENTED);
  EXPECT_EQ(describe_as(LimitExceeded("f", "m")).code, StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(describe_as(ResourceExhausted("m")).code, StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(describe_as(std::bad_alloc()).code, StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(describe_as(DeviceError("m")).code, StatusCode::UNAVAILABLE);
  EXPECT_EQ(describe_as(Stopping()).code, StatusCode::UNAVAILABLE);
  EXPECT_EQ(describe_as(DeadlineExceeded("m")).code, StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(describe_as(Cancelled()).code, StatusCode::CANCELLED);
  EXPECT_EQ(describe_as(std::runtime_error("m")).code, StatusCode::INTERNAL);
  EXPECT_EQ(describe_as(7).code, StatusCode::INTERNAL);
}

// A lack of threads, memory or descriptors on the host is not a defect of the daemon.
TEST(Status, WhatTheHostLacksIsExhausted) {
  const auto of = [](std::errc code) { return describe_as(std::system_error(std::make_error_code(code), "thread")); };
  for (const auto& [code, lacking] : {std::pair{std::errc::resource_unavailable_try_again, "threads"},
                                      {std::errc::not_enough_memory, "memory"},
                                      {std::errc::too_many_files_open, "file descriptors"},
                                      {std::errc::too_many_files_open_in_system, "file descriptors"}}) {
    const Failure failure = of(code);
    EXPECT_EQ(failure.code, grpc::StatusCode::RESOURCE_EXHAUSTED);
    EXPECT_NE(failure.message.find(std::string("out of ") + lacking), std::string::npos) << failure.message;
    EXPECT_EQ(failure.subject, "daemon");
    EXPECT_GT(failure.retry_after_seconds, 0);
  }
  EXPECT_EQ(of(std::errc::permission_denied).code, grpc::StatusCode::INTERNAL);
}

TEST(Status, KeepsMessageAndField) {
  const Failure failure = describe_as(InvalidInput("spec.thickness", "is -1"));
  EXPECT_EQ(failure.message, "is -1");
  EXPECT_EQ(failure.field, "spec.thickness");
}

pb::RpcStatus details(const Failure& failure) {
  const grpc::Status status = to_status(failure);
  pb::RpcStatus out;
  EXPECT_TRUE(out.ParseFromString(status.error_details()));
  EXPECT_EQ(out.code(), status.error_code());
  EXPECT_EQ(out.message(), status.error_message());
  return out;
}

// Exactly one detail, of the type with that name.
template <class Detail>
Detail only_detail(const Failure& failure, const std::string& name) {
  const auto all = details(failure);
  Detail detail;
  EXPECT_EQ(all.details_size(), 1);
  if (all.details_size() != 1) return detail;
  EXPECT_EQ(all.details(0).type_url(), "type.googleapis.com/google.rpc." + name);
  EXPECT_TRUE(detail.ParseFromString(all.details(0).value()));
  return detail;
}

// Byte for byte, as any library for google.rpc reads it.
TEST(Status, DetailsAreABadRequestOnTheWire) {
  const grpc::Status status = to_status(describe_as(InvalidInput("f", "m")));
  const std::string violation(
      "\x0a\x01"
      "f"
      "\x12\x01"
      "m",
      6);
  const std::string type = "type.googleapis.com/google.rpc.BadRequest";
  const std::string any = std::string("\x0a") + static_cast<char>(type.size()) + type + "\x12\x08\x0a\x06" + violation;
  EXPECT_EQ(status.error_details(), std::string("\x08\x03\x12\x01"
                                                "m"
                                                "\x1a",
                                                6) +
                                        static_cast<char>(any.size()) + any);
}

TEST(Status, AFieldIsABadRequest) {
  const auto request = only_detail<pb::BadRequest>(describe_as(NotFound("scene_id", "is gone")), "BadRequest");
  ASSERT_EQ(request.field_violations_size(), 1);
  EXPECT_EQ(request.field_violations(0).field(), "scene_id");
  EXPECT_EQ(request.field_violations(0).description(), "is gone");
}

TEST(Status, AQuotaTellsItsSubject) {
  const Failure failure = describe_as(LimitExceeded::quota("client:me", "too many"));
  EXPECT_EQ(failure.field, "");
  EXPECT_EQ(failure.retry_after_seconds, 0);
  const auto quota = only_detail<pb::QuotaFailure>(failure, "QuotaFailure");
  ASSERT_EQ(quota.violations_size(), 1);
  EXPECT_EQ(quota.violations(0).subject(), "client:me");
  EXPECT_EQ(quota.violations(0).description(), "too many");
  EXPECT_EQ(only_detail<pb::QuotaFailure>(describe_as(ResourceExhausted("m")), "QuotaFailure").violations(0).subject(),
            "daemon");
}

TEST(Status, ATimeToRetryIsToldToTheBillionth) {
  for (const double seconds : {0.25, 1.0, 3.5, 1e-6}) {
    const auto all = details(describe_as(LimitExceeded::quota("client:me", "too many", seconds)));
    ASSERT_EQ(all.details_size(), 2);
    EXPECT_EQ(all.details(1).type_url(), "type.googleapis.com/google.rpc.RetryInfo");
    pb::RetryInfo retry;
    ASSERT_TRUE(retry.ParseFromString(all.details(1).value()));
    const auto& delay = retry.retry_delay();
    EXPECT_TRUE(delay.nanos() >= 0 && delay.nanos() < 1'000'000'000);
    EXPECT_NEAR(static_cast<double>(delay.seconds()) + delay.nanos() * 1e-9, seconds, 1.1e-9);
  }
}

TEST(Status, NeitherFieldNorQuotaNoDetails) {
  for (const Failure& failure : {describe_as(DeviceError("m")), describe_as(Stopping()), describe_as(Cancelled())})
    EXPECT_EQ(to_status(failure).error_details(), "");
}

TEST(Status, NamesEveryCode) {
  EXPECT_EQ(code_name(grpc::StatusCode::OK), "OK");
  EXPECT_EQ(code_name(grpc::StatusCode::RESOURCE_EXHAUSTED), "RESOURCE_EXHAUSTED");
  EXPECT_EQ(code_name(grpc::StatusCode::ABORTED), "ABORTED");
  EXPECT_EQ(code_name(grpc::StatusCode::UNAUTHENTICATED), "UNAUTHENTICATED");
  EXPECT_EQ(code_name(static_cast<grpc::StatusCode>(17)), "UNKNOWN");
  EXPECT_EQ(code_name(static_cast<grpc::StatusCode>(-1)), "UNKNOWN");
}

}  // namespace
}  // namespace collided::server
