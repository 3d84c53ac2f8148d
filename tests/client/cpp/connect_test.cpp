// Connecting to a daemon: where tokens may be sent, TLS files, refusals.

#include <grpcpp/support/status.h>
#include <gtest/gtest.h>

#include <fstream>

#include "client/cpp/client.hpp"
#include "client/cpp/transport/grpc/address.hpp"
#include "client/cpp/transport/grpc/channel.hpp"
#include "client/cpp/transport/grpc/deadline.hpp"
#include "collided/v1/error_details.pb.h"

namespace collided::client {
namespace {

TEST(Address, IsLocalIfItCannotLeaveTheHost) {
  for (const char* local :
       {"unix:/run/s", "unix-abstract:s", "localhost", "localhost:50551", "127.0.0.1:50551", "127.8.9.1", "[::1]:50551",
        "::1", "ipv4:127.0.0.1:1", "ipv6:[::1]:1", "dns:///localhost:1"})
    EXPECT_TRUE(is_local_address(local)) << local;
  for (const char* remote :
       {"", "example.org:50551", "127.evil.org:50551", "127.0.0.1.evil.org", "localhost.evil.org", "10.0.0.1:50551",
        "0.0.0.0:50551", "[::]:50551", "[fe80::1]:1", "ipv4:8.8.8.8:1", "dns://8.8.8.8/localhost:1", "[::1", "[",
        "xunix:/run/s", "ipv4:127.0.0.1:1,8.8.8.8:1", "ipv6:[::1]:1,[fd00::2]:1"})
    EXPECT_FALSE(is_local_address(remote)) << remote;
}

/// What check_address() says; empty if it takes it.
std::string refused_address(const std::string& address) {
  try {
    check_address(address);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), grpc::INVALID_ARGUMENT);
    EXPECT_EQ(e.field(), "address");
    return e.message();
  }
  return "";
}

TEST(Address, NeedsAPortThatThereIs) {
  for (const char* good : {"localhost:1",
                           "localhost:65535",
                           "10.0.0.1:50551",
                           "[::1]:50551",
                           "[fe80::1%eth0]:1",
                           "unix:/run/s:70000",
                           "unix:s",
                           "unix:///run/s",
                           "unix-abstract:s",
                           "vsock:2:70000",
                           "xds:///name",
                           "dns:localhost:1",
                           "dns:///localhost:1",
                           "dns://8.8.8.8/localhost:1",
                           "dns:example.org",
                           "dns:///example.org",
                           "ipv4:127.0.0.1:1",
                           "ipv4:127.0.0.1",
                           "ipv4:127.0.0.1:1,127.0.0.1:2",
                           "ipv6:[::1]:1",
                           "ipv6:::1"})
    EXPECT_EQ(refused_address(good), "") << good;
  for (const std::string host :
       {"localhost", "10.0.0.1", "[::1]", "dns:localhost", "dns:///localhost", "dns://8.8.8.8/localhost",
        "ipv4:127.0.0.1", "ipv4:127.0.0.1:1,127.0.0.1", "ipv6:[::1]"})
    for (const std::string port : {"70000", "65536", "0", "-1", "+1", "", "1x", " 1", "99999999999999999999"})
      EXPECT_EQ(refused_address(host + ":" + port), "address is '" + host + ":" + port + "', whose port is '" + port +
                                                        "'; it must be a number from 1 to 65535");
  for (const std::string portless : {"localhost", "example.org", "127.0.0.1", "::1", "[::1]", "[::1"})
    EXPECT_EQ(refused_address(portless),
              "address is '" + portless + "', which has no port; it needs one from 1 to 65535, as in localhost:50551");
  EXPECT_NE(refused_address(""), "");
  EXPECT_THROW(Client::connect("localhost:70000"), Error);
}

using std::chrono::milliseconds;

// Times beyond any clock's range mean no deadline, instead of one long past.
TEST(Deadline, MayBeAsLongAsItLikes) {
  constexpr auto kDay = std::chrono::hours(24);
  for (const auto& [deadline, more] : {std::pair{milliseconds::max(), milliseconds(0)},
                                       {milliseconds::max(), milliseconds(1000)},
                                       {milliseconds::max() - milliseconds(1), milliseconds(0)},
                                       {milliseconds(kDay * 365 * 300), milliseconds(0)},
                                       {milliseconds(kDay * 2), milliseconds(0)}}) {
    const auto context = ChannelFactory("unix:/run/s", {.deadline = deadline}).call_context("", more);
    EXPECT_GT(context->deadline(), std::chrono::system_clock::now() + kDay) << deadline.count();
  }
  const auto late = ChannelFactory("unix:/run/s", {.deadline = milliseconds::min()}).call_context();
  EXPECT_LE(late->deadline(), std::chrono::system_clock::now());
}

TEST(Deadline, OfConnectingMayBeNoneOrPast) {
  const std::string nobody = "unix:" + testing::TempDir() + "nobody-listens";
  EXPECT_THROW(ChannelFactory(nobody, {.patience = milliseconds::min()}).connect(), Error);
  EXPECT_EQ(gpr_time_cmp(deadline_in(milliseconds::max()), no_deadline()), 0);
  EXPECT_EQ(gpr_time_cmp(deadline_in(std::chrono::nanoseconds::max()), no_deadline()), 0);
}

Error refusal(const std::string& address, const ConnectOptions& options) {
  try {
    ChannelFactory(address, options);
  } catch (const Error& e) {
    return e;
  }
  return {0, "it was not refused"};
}

TEST(Token, LeavesTheHostOverTlsOrWhereThatIsAllowed) {
  const Error plain = refusal("example.org:50551", {.token = "secret"});
  EXPECT_EQ(plain.code(), 3) << plain.what();
  EXPECT_EQ(plain.field(), "token");
  EXPECT_EQ(plain.message().find("secret"), std::string::npos);
  EXPECT_EQ(refusal("example.org:50551", {.token = "secret", .allow_insecure_token = true}).code(), 0);
  EXPECT_EQ(refusal("127.0.0.1:50551", {.token = "secret"}).code(), 0);
  EXPECT_EQ(refusal("unix:/run/s", {.token = "secret"}).code(), 0);
  EXPECT_EQ(refusal("unix:/run/s", {.token = "line\r\nx-admin: 1"}).code(), 3);
}

TEST(Tls, OptionsThatDoNotGoTogetherAndFilesThatAreNotThereAreNamed) {
  EXPECT_EQ(refusal("a:1", {.tls_ca = "/nonexistent"}).field(), "tls_ca");
  EXPECT_EQ(refusal("a:1", {.tls_certificate = "a", .tls_key = "b"}).field(), "tls_ca");
  EXPECT_EQ(refusal("a:1", {.tls_ca = "a", .tls_certificate = "a"}).field(), "tls_key");
  EXPECT_EQ(refusal("a:1", {.tls_server_name = "a"}).field(), "tls_ca");
  const std::string ca = testing::TempDir() + "ca.pem";
  std::ofstream(ca) << "-----BEGIN CERTIFICATE-----\n";
  EXPECT_EQ(refusal("a:1", {.tls_ca = ca}).code(), 0);
  EXPECT_EQ(refusal("a:1", {.tls_ca = ca, .tls_certificate = ca, .tls_key = "/none"}).field(), "tls_key");
  EXPECT_EQ(refusal("a:1", {.tls_ca = ca, .tls_certificate = ca, .tls_key = ca}).field(), "tls_key");
  const std::string text = testing::TempDir() + "text.pem";
  std::ofstream(text) << "no certificate\n";
  EXPECT_EQ(refusal("a:1", {.tls_ca = text}).message(), "tls_ca is '" + text + "', which holds no CERTIFICATE (PEM)");
}

void pack(v1::RpcStatus& status, const std::string& name, const google::protobuf::MessageLite& detail) {
  v1::PackedDetail& packed = *status.add_details();
  packed.set_type_url("type.googleapis.com/google.rpc." + name);
  packed.set_value(detail.SerializeAsString());
}

TEST(Details, AreReadFromTheStatus) {
  v1::BadRequest bad;
  bad.add_field_violations()->set_field("spec.thickness");
  v1::QuotaFailure quota;
  quota.add_violations()->set_subject("client:a");
  quota.mutable_violations(0)->set_description("max_scenes_per_client is 2");
  v1::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(2);
  retry.mutable_retry_delay()->set_nanos(500'000'000);
  v1::RpcStatus all;
  pack(all, "BadRequest", bad);
  pack(all, "QuotaFailure", quota);
  pack(all, "RetryInfo", retry);
  pack(all, "Help", bad);
  const auto error = error_of(grpc::Status(grpc::RESOURCE_EXHAUSTED, "no", all.SerializeAsString()));
  ASSERT_TRUE(error);
  EXPECT_EQ(error->field(), "spec.thickness");
  EXPECT_EQ(error->quota(), "client:a: max_scenes_per_client is 2");
  EXPECT_EQ(error->retry_after_seconds(), 2.5);
}

TEST(Details, ThatAreNoneLeaveTheErrorAsItIs) {
  v1::RpcStatus cut;
  pack(cut, "BadRequest", cut);
  cut.mutable_details(0)->set_value("\x0a\xff");
  for (const std::string& bytes : {std::string(), std::string("\xff\xff"), cut.SerializeAsString()}) {
    const auto error = error_of(grpc::Status(grpc::NOT_FOUND, "no", bytes));
    ASSERT_TRUE(error);
    EXPECT_EQ(error->field() + error->quota(), "");
    EXPECT_FALSE(error->retry_after_seconds());
  }
  EXPECT_FALSE(error_of(grpc::Status::OK));
}

TEST(Errors, OfALostConnectionAreToldFromRefusals) {
  for (const int code : {1, 13, 14}) EXPECT_TRUE(is_connection_lost(Error(code, ""))) << code;
  for (const int code : {0, 3, 4, 5, 7, 8, 9, 10, 15, 16}) EXPECT_FALSE(is_connection_lost(Error(code, ""))) << code;
}

}  // namespace
}  // namespace collided::client
