// Attacks on the entrance: connections, and calls without requests.
#include <gtest/gtest.h>
#include <unistd.h>

#include <functional>
#include <string>
#include <vector>

#include "tests/integration/support/bystander.hpp"
#include "tests/integration/support/peers/raw_http2.hpp"
#include "tests/integration/support/peers/raw_stream.hpp"

namespace collided::test {
namespace {

constexpr auto kReflection = "/grpc.reflection.v1.ServerReflection/ServerReflectionInfo";

// More silent connections than the process has descriptors for, held and closed again.
TEST(Entrance, SilentConnectionsKeepNobodyOut) {
  constexpr int kConnections = 1224;
  DaemonProcess daemon({"--address", "127.0.0.1:0"}, test_backend(), 1024);
  const Probe probe(daemon);
  Aftermath aftermath(probe, daemon.tcp_address());
  std::vector<int> silent;
  for (int i = 0; i < kConnections; ++i) silent.push_back(connect_to(daemon.tcp_address()));
  expect_new_client_served(daemon.tcp_address());
  aftermath.bystander().expect_served();
  EXPECT_TRUE(probe.is_ready());
  for (const int connection : silent)
    if (connection >= 0) close(connection);
  aftermath.expect_unharmed();
}

/// What is reset, and over which transport. The honest clients use the other one.
struct Flood {
  std::string path;
  bool is_unix = false;
};

void PrintTo(const Flood& flood, std::ostream* out) {
  *out << flood.path << (flood.is_unix ? " over Unix sockets" : "");
}

class Resets : public testing::TestWithParam<Flood> {};

// gRPC keeps each call until it is accepted, however fast they come and go.
TEST_P(Resets, TakeLittleMemory) {
  constexpr int kBatch = 1000, kBatches = 1000;
  DaemonProcess daemon({"--address", "127.0.0.1:0"});
  const Probe probe(daemon);
  const auto& [path, is_unix] = GetParam();
  Aftermath aftermath(probe, is_unix ? daemon.tcp_address() : daemon.address());
  const double before = probe.resident_bytes();
  RawHttp2 attacker(is_unix ? daemon.address() : daemon.tcp_address());
  int sent = 0;
  while (sent < kBatches && attacker.reset_calls(path, kBatch)) ++sent;
  EXPECT_LT(sent, kBatches) << "the connection was not ended";
  EXPECT_LT(probe.peak_resident_bytes() - before, memory_limit(256));
  aftermath.expect_unharmed();
  EXPECT_GE(probe.metric("collided_reset_floods_total"), 1);
}

INSTANTIATE_TEST_SUITE_P(Entrance, Resets,
                         testing::Values(Flood{method_path("StreamFrames")}, Flood{method_path("StreamFrames"), true},
                                         Flood{method_path("GetScene")}, Flood{method_path("GetScene"), true},
                                         Flood{method_path("UploadMesh")}, Flood{"/grpc.health.v1.Health/Check"},
                                         Flood{kReflection}, Flood{"/no.Service/Method"}),
                         [](const auto& info) {
                           const std::string& path = info.param.path;
                           return "Of" + path.substr(path.rfind('/') + 1) +
                                  (info.param.is_unix ? "OverUnix" : "OverTcp");
                         });

/// What a client sends after a call that was served, again and again. False if the daemon has ended the connection.
struct Noise {
  std::string name;
  std::function<bool(RawHttp2& attacker)> send;
};

void PrintTo(const Noise& noise, std::ostream* out) { *out << noise.name; }

class NoiseOfAClient : public testing::TestWithParam<Noise> {};

// gRPC would read it for as long as it does not pause, and others' connections not at all.
TEST_P(NoiseOfAClient, EndsItsConnection) {
  constexpr uint64_t kMaxBytes = 1 << 30;
  DaemonProcess daemon({"--address", "127.0.0.1:0", "--max-network-mb", "128"});
  const Probe probe(daemon);
  Aftermath aftermath(probe, daemon.address());
  RawHttp2 attacker(daemon.tcp_address());
  ASSERT_TRUE(attacker.call(method_path("GetServerInfo")));
  while (attacker.sent() < kMaxBytes && GetParam().send(attacker)) continue;
  EXPECT_LT(attacker.sent(), kMaxBytes) << "the connection was not ended";
  aftermath.expect_unharmed();
  EXPECT_GE(probe.metric("collided_evicted_connections_total"), 1);
}

constexpr int kFrames = 10'000;

INSTANTIATE_TEST_SUITE_P(
    Entrance, NoiseOfAClient,
    testing::Values(Noise{"Settings", [](RawHttp2& attacker) { return attacker.send_settings(kFrames); }},
                    Noise{"Priorities", [](RawHttp2& attacker) { return attacker.send_priorities(kFrames); }},
                    Noise{"EmptyData",
                          [](RawHttp2& attacker) {
                            return attacker.send_empty_data(method_path("StreamFrames"), kFrames);
                          }},
                    Noise{"PrioritiesBetweenCalls",
                          [](RawHttp2& attacker) {
                            return attacker.send_priorities(10 * kFrames) &&
                                   attacker.call(method_path("GetServerInfo"));
                          }}),
    [](const auto& info) { return info.param.name; });

// A client may be mistaken often, and behind a proxy all share one connection.
TEST(Entrance, RefusedStreamsAreNoFlood) {
  constexpr int kRefused = 2500;
  DaemonProcess daemon;
  const Probe probe(daemon);
  const auto stub = pb::CollisionService::NewStub(daemon.channel());
  for (int i = 0; i < kRefused; ++i)
    ASSERT_EQ(Stream(*stub, "no-such-scene").finish().error_code(), grpc::NOT_FOUND) << i;
  EXPECT_EQ(probe.metric("collided_reset_floods_total"), 0);
}

}  // namespace
}  // namespace collided::test
