// The table from exceptions to gRPC codes, and its details on the wire.
#include "server/service/status.hpp"

#include <gtest/gtest.h>

#include <new>

#include "gpu/detector.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

template <class Error>
Failure describe_as(const Error& error) {
  return describe(std::make_exception_ptr(error));
}

TEST(Status, MapsEveryException) {
  using grpc::StatusCode;
  EXPECT_EQ(describe_as(InvalidInput("f", "m")).code, StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(describe_as(NotFound("f", "m")).code, StatusCode::NOT_FOUND);
  EXPECT_EQ(describe_as(FailedPrecondition("f", "m")).code, StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(describe_as(Unimplemented("f", "m")).code, StatusCode::UNIMPLEMENTED);
  EXPECT_EQ(describe_as(LimitExceeded("f", "m")).code, StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(describe_as(ResourceExhausted("m")).code, StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(describe_as(std::bad_alloc()).code, StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(describe_as(DeviceError("m")).code, StatusCode::UNAVAILABLE);
  EXPECT_EQ(describe_as(Stopping()).code, StatusCode::UNAVAILABLE);
  EXPECT_EQ(describe_as(Cancelled()).code, StatusCode::CANCELLED);
  EXPECT_EQ(describe_as(std::runtime_error("m")).code, StatusCode::INTERNAL);
  EXPECT_EQ(describe_as(7).code, StatusCode::INTERNAL);
}

TEST(Status, KeepsMessageAndField) {
  const Failure failure = describe_as(InvalidInput("spec.thickness", "is -1"));
  EXPECT_EQ(failure.message, "is -1");
  EXPECT_EQ(failure.field, "spec.thickness");
}

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

TEST(Status, NoFieldNoDetails) { EXPECT_EQ(to_status(describe_as(ResourceExhausted("m"))).error_details(), ""); }

TEST(Status, OnlyALostSceneDeviceOrCallerEndsAStream) {
  EXPECT_TRUE(ends_stream(describe_as(NotFound("f", "m"))));
  EXPECT_TRUE(ends_stream(describe_as(DeviceError("m"))));
  EXPECT_TRUE(ends_stream(describe_as(Cancelled())));
  EXPECT_FALSE(ends_stream(describe_as(InvalidInput("f", "m"))));
  EXPECT_FALSE(ends_stream(describe_as(ResourceExhausted("m"))));
}

}  // namespace
}  // namespace collided::server
