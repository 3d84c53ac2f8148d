// Attacks on the way in: connections, and calls that ask for nothing.
#include <gtest/gtest.h>
#include <unistd.h>

#include <vector>

#include "tests/integration/bystander.hpp"
#include "tests/integration/raw_http2.hpp"

namespace collided::test {
namespace {

constexpr auto kStreamFrames = "/collided.v1.CollisionService/StreamFrames";

// More than the process has descriptors for, without a word, held and closed again.
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

// gRPC keeps each call until it is taken up, however fast they come and go.
TEST(Entrance, StreamsThatAreResetTakeLittleMemory) {
  constexpr int kBatch = 1000, kBatches = 1000;
  DaemonProcess daemon({"--address", "127.0.0.1:0"});
  const Probe probe(daemon);
  Aftermath aftermath(probe, daemon.address());
  const double before = probe.resident_bytes();
  RawHttp2 attacker(daemon.tcp_address());
  int sent = 0;
  while (sent < kBatches && attacker.reset_calls(kStreamFrames, kBatch)) ++sent;
  EXPECT_LT(sent, kBatches) << "the connection was not ended";
  EXPECT_LT(probe.peak_resident_bytes() - before, memory_limit(256));
  aftermath.expect_unharmed();
  EXPECT_GE(probe.metric("collided_reset_floods_total"), 1);
}

}  // namespace
}  // namespace collided::test
