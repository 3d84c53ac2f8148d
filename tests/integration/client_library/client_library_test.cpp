// The C++ client library against a real daemon: the same frames over every transport, and streams that break.
#include <gtest/gtest.h>

#include <cstring>
#include <optional>
#include <span>

#include "tests/integration/client_library/client_layers.hpp"
#include "tests/integration/client_library/client_ways.hpp"
#include "tests/integration/support/peers/tcp_proxy.hpp"

namespace collided::test {
namespace {

using client::Contacts;
using client::Error;
using client::Local;

/// Moves one vertex far away, from where the previous frame left it.
FrameOutput ask_sparse(FrameStream& stream, uint64_t id) {
  const std::string index = pack<uint32_t>({static_cast<uint32_t>(id)}), there = pack_points({{0.5, 0.5, 9}});
  return ask(stream, id, {.positions = bytes_of(there), .indices = bytes_of(index)});
}

void expect_equal(const Contacts& a, const Contacts& b) {
  EXPECT_EQ(a.count, b.count);
  EXPECT_TRUE(a.elements == b.elements);
  EXPECT_TRUE(a.stencils == b.stencils);
  EXPECT_TRUE(a.toi == b.toi);
  EXPECT_TRUE(a.distance == b.distance);
  EXPECT_TRUE(a.weights == b.weights);
  EXPECT_TRUE(a.flags == b.flags);
}

void expect_equal(const FrameOutput& a, const FrameOutput& b) {
  EXPECT_GT(a.vertex_triangle.count, 100u);
  expect_equal(a.vertex_triangle, b.vertex_triangle);
  expect_equal(a.edge_edge, b.edge_edge);
}

/// The error that a stream ends with.
Error end_of(FrameStream& stream, uint64_t next_id) {
  try {
    for (uint64_t id = next_id;; ++id) ask_whole(stream, id);
  } catch (const Error& error) {
    return error;
  }
}

TEST(ClientLibrary, FramesAreTheSameOverEveryTransport) {
  LocalDaemon daemon({"--address", "127.0.0.1:0"});
  Client unix_client = Client::connect(daemon.process().address());
  Client tcp_client = Client::connect(daemon.process().tcp_address());
  Client here = local();
  struct Place {
    Client* client;
    client::LocalOptions local;
    bool is_shared;
  };
  const Place places[] = {{&here, {}, true},
                          {&unix_client, {.use = Local::kOff}, false},
                          {&tcp_client, {.use = Local::kOff}, false},
                          {&unix_client, {}, true},
                          {&tcp_client, {}, true},
                          {&unix_client, {.use = Local::kOn, .output_bytes = 32 << 10}, true},
                          {&unix_client, {.use = Local::kOn, .output_bytes = 0}, true}};
  std::vector<FrameStream> streams;
  for (const Place& place : places) {
    streams.push_back(place.client->stream(make_layers(*place.client), {.local = place.local}));
    EXPECT_EQ(!streams.back().input(64).empty(), place.is_shared);
  }
  for (uint64_t id = 1; id <= 6; ++id) {
    const FrameOutput expected = ask_whole(streams[0], id);
    for (size_t i = 1; i < streams.size(); ++i) {
      SCOPED_TRACE("frame " + std::to_string(id) + ", place " + std::to_string(i));
      expect_equal(expected, ask_whole(streams[i], id));
    }
  }
  for (FrameStream& stream : streams) EXPECT_NO_THROW(stream.finish());
}

TEST(ClientLibrary, PositionsThatAreWrittenIntoSharedMemoryAreThoseOfTheFrame) {
  LocalDaemon daemon;
  for (const Way way : {Way::kSharedMemory, Way::kInProcess}) {
    Client client = client_by(way, daemon.process().address());
    FrameStream near = client.stream(make_layers(client));
    FrameStream far = client.stream(make_layers(client), {.local = {.use = Local::kOff}});
    for (uint64_t id = 1; id <= 6; ++id) {
      const std::string positions = layers_at(id);
      const auto room = near.input(positions.size());
      ASSERT_EQ(room.size(), positions.size());
      std::memcpy(room.data(), positions.data(), positions.size());
      expect_equal(ask(near, id, {.positions = room}), ask_whole(far, id));
    }
  }
}

TEST(ClientLibrary, ABrokenConnectionIsResumedWithSparseFrames) {
  LocalDaemon daemon({"--address", "127.0.0.1:0"});
  TcpProxy proxy(daemon.process().tcp_address());
  Client client = Client::connect(daemon.process().address());
  const client::StreamOptions remote{.local = {.use = Local::kOff}};
  std::optional<Client> cut = Client::connect(proxy.address());
  const pb::Scene scene = make_layers(*cut);
  FrameStream whole = client.stream(make_layers(client)), broken = cut->stream(scene, remote);
  for (const uint64_t id : {1, 2}) expect_equal(ask_whole(whole, id), ask_whole(broken, id));
  proxy.cut();
  const Error end = end_of(broken, 3);
  EXPECT_TRUE(client::is_connection_lost(end)) << end.what();
  FrameStream next = client.resume(scene, remote);
  EXPECT_EQ(next.scene().last_frame_id(), 2u);
  for (const uint64_t id : {3, 4}) expect_equal(ask_sparse(whole, id), ask_sparse(next, id));
}

// The daemon closes the connection; the scene stays, and continues over any transport.
TEST(ClientLibrary, AStreamThatTheDaemonClosedIsResumedOverEitherTransport) {
  LocalDaemon daemon({"--max-idle-seconds", "0.5"});
  Client client = Client::connect(daemon.process().address());
  const pb::Scene scene = make_layers(client), reference = make_layers(client);
  uint64_t id = 0;
  for (const Local use : {Local::kOn, Local::kOff, Local::kOn}) {
    FrameStream whole = client.resume(reference);
    FrameStream stream = client.resume(scene, {.local = {.use = use}});
    EXPECT_EQ(stream.scene().last_frame_id(), id);
    ++id;
    expect_equal(id == 1 ? ask_whole(whole, id) : ask_sparse(whole, id),
                 id == 1 ? ask_whole(stream, id) : ask_sparse(stream, id));
    EXPECT_TRUE(daemon.probe().streams_become(0));
    const Error end = end_of(stream, id + 1);
    EXPECT_EQ(end.code(), grpc::RESOURCE_EXHAUSTED) << end.what();
    EXPECT_NE(end.message().find("max_idle_seconds is 0.5"), std::string::npos) << end.what();
  }
}

TEST(ClientLibrary, AStreamThatAnotherOneTookOverIsTold) {
  LocalDaemon daemon;
  Client client = Client::connect(daemon.process().address());
  const pb::Scene scene = make_layers(client);
  for (const Local use : {Local::kOn, Local::kOff}) {
    FrameStream first = client.resume(scene, {.local = {.use = use}});
    FrameStream second = client.resume(scene, {.local = {.use = use}});
    const uint64_t id = second.scene().last_frame_id() + 1;
    const Error end = end_of(first, id);
    EXPECT_EQ(end.code(), grpc::ABORTED) << end.what();
    EXPECT_FALSE(client::is_connection_lost(end));
    EXPECT_GT(ask_whole(second, id).vertex_triangle.count, 0u);
  }
}

TEST(ClientLibrary, ADaemonThatDiedIsSeenAndItsSceneMadeAnew) {
  LocalDaemon daemon;
  std::optional<Client> client = Client::connect(daemon.process().address());
  const pb::Scene scene = make_layers(*client);
  FrameStream local = client->stream(scene, {.local = {.use = Local::kOn}});
  FrameStream remote = client->stream(make_layers(*client), {.local = {.use = Local::kOff}});
  const FrameOutput expected = ask_whole(local, 1);
  ask_whole(remote, 1);
  daemon.process().signal(SIGKILL);
  daemon.process().wait();
  for (FrameStream* stream : {&local, &remote}) {
    const Error end = end_of(*stream, 2);
    EXPECT_TRUE(client::is_connection_lost(end)) << end.what();
  }
  DaemonProcess next({"--address", daemon.process().address(), "--local-socket", daemon.path()});
  client = Client::connect(daemon.process().address());
  try {
    client->resume(scene, {.local = {.use = Local::kOn}});
    ADD_FAILURE() << "a scene came back from the dead";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::NOT_FOUND) << error.what();
  }
  FrameStream again = client->stream(make_layers(*client), {.local = {.use = Local::kOn}});
  expect_equal(ask_whole(again, 1), expected);
}

}  // namespace
}  // namespace collided::test
