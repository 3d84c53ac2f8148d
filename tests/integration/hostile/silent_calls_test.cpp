// Silent calls: they take no place from others, no thread, and they end.
#include <gtest/gtest.h>

#include <deque>
#include <fstream>
#include <functional>
#include <map>

#include "grpc/reflection/v1/reflection.pb.h"
#include "tests/integration/support/bystander.hpp"
#include "tests/integration/support/peers/raw_stream.hpp"

namespace collided::test {
namespace {

constexpr char kReflection[] = "/grpc.reflection.v1.ServerReflection/ServerReflectionInfo";

constexpr char kHealthCheck[] = "/grpc.health.v1.Health/Check", kHealthWatch[] = "/grpc.health.v1.Health/Watch";

std::string list_services() {
  grpc::reflection::v1::ServerReflectionRequest request;
  request.set_list_services("");
  return request.SerializeAsString();
}

using Ends = std::map<grpc::StatusCode, int>;

/// The outcomes of calls that are only begun; `meanwhile` runs while they are open, and a new client is served.
Ends ends_of_silent(
    const DaemonProcess& daemon, const std::string& path, int count, const std::function<void()>& meanwhile = [] {}) {
  const auto channel = channel_to(daemon.address(), 77);
  std::deque<RawStream> calls;
  for (int i = 0; i < count; ++i) calls.emplace_back(channel, path);
  meanwhile();
  expect_new_client_served(daemon.address());
  Ends ends;
  for (auto& call : calls) ++ends[call.finish().error_code()];
  return ends;
}

TEST(SilentCalls, StreamsThatDoNotOpenTakeNoPlace) {
  constexpr int kStreams = 4, kSilent = 16;
  const auto streams = std::to_string(kStreams);
  DaemonProcess daemon({"--max-streams", streams, "--max-streams-per-client", streams, "--max-silent-seconds", "2"});
  const Probe probe(daemon);
  Aftermath aftermath(probe, daemon.address());
  auto ends = ends_of_silent(daemon, method_path("StreamFrames"), kSilent);
  EXPECT_GT(ends[grpc::DEADLINE_EXCEEDED], 0);
  EXPECT_GE(ends[grpc::RESOURCE_EXHAUSTED], kSilent - kStreams);  // the oldest were evicted for newer ones
  EXPECT_EQ(ends[grpc::DEADLINE_EXCEEDED] + ends[grpc::RESOURCE_EXHAUSTED], kSilent);
  aftermath.expect_unharmed();
}

TEST(SilentCalls, AnOpeningThatIsLateIsToldWhatItMissed) {
  DaemonProcess daemon({"--max-silent-seconds", "0.1"});
  RawStream call(daemon.channel(), method_path("StreamFrames"));
  const auto status = call.finish();
  EXPECT_EQ(status.error_code(), grpc::DEADLINE_EXCEEDED);
  EXPECT_EQ(status.error_message(), "the opening of a stream did not come within 0.1 s");
}

TEST(SilentCalls, AnOpenStreamMayBeSilent) {
  DaemonProcess daemon({"--max-silent-seconds", "0.1"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  Stream stream(*stub, make_scene(*stub, tip_request()));
  ASSERT_TRUE(stream.opened());
  EXPECT_EQ(RawStream(daemon.channel(), method_path("StreamFrames")).finish().error_code(), grpc::DEADLINE_EXCEEDED);
  expect_tip_contact(stream.ask(first_frame(2)), 2);
}

TEST(SilentCalls, AnUploadThatStallsEndsAndFreesItsMesh) {
  DaemonProcess daemon({"--max-silent-seconds", "0.2"});
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  auto request = tip_request();
  request.mutable_spec()->mutable_meshes(1)->clear_triangles();
  request.mutable_spec()->mutable_meshes(1)->set_triangle_count(1);
  pb::UploadMeshRequest chunk;
  chunk.set_scene_id(make_scene(*stub, request));
  chunk.set_mesh(1);
  for (const bool begins : {false, true}) {
    RawStream stalled(daemon.channel(), method_path("UploadMesh"));
    if (begins) stalled.write(chunk.SerializeAsString());
    const auto status = stalled.finish();
    EXPECT_EQ(status.error_code(), grpc::DEADLINE_EXCEEDED);
    EXPECT_NE(status.error_message().find("chunk of the upload"), std::string::npos) << status.error_message();
  }
  chunk.set_triangles(pack<uint32_t>({0, 1, 2}));
  const auto status = raw_call(daemon.channel(), method_path("UploadMesh"), chunk.SerializeAsString());
  EXPECT_TRUE(status.ok()) << status.error_message();
}

TEST(SilentCalls, OfReflectionTakeNoThreads) {
  constexpr int kCalls = 500;
  DaemonProcess daemon({"--max-silent-seconds", "2"});
  const Probe probe(daemon);
  Aftermath aftermath(probe, daemon.address());
  const double threads = probe.threads();
  auto ends = ends_of_silent(daemon, kReflection, kCalls, [&] { EXPECT_LT(probe.threads(), threads + 16); });
  EXPECT_EQ(ends[grpc::DEADLINE_EXCEEDED] + ends[grpc::RESOURCE_EXHAUSTED], kCalls);
  EXPECT_GT(ends[grpc::DEADLINE_EXCEEDED], 0);
  aftermath.expect_unharmed();
}

// For each method, with and without a token; the wait includes a second for each MiB of the largest message.
TEST(SilentCalls, OfOneMessageEndInTime) {
  DaemonProcess daemon({"--max-silent-seconds", "0.1", "--max-message-mb", "1"});
  for (const std::string& path : {method_path("GetServerInfo"), method_path("CreateScene"), method_path("DetectFrame"),
                                  std::string(kHealthCheck), std::string(kHealthWatch)}) {
    const auto status = RawStream(daemon.channel(), path).finish();
    EXPECT_EQ(status.error_code(), grpc::DEADLINE_EXCEEDED) << path;
    EXPECT_NE(status.error_message().find(" did not come within "), std::string::npos) << status.error_message();
  }
}

TEST(SilentCalls, OfHealthAreFew) {
  constexpr int kCalls = 400, kMax = 256;  // of one host
  for (const auto* path : {kHealthCheck, kHealthWatch}) {
    DaemonProcess daemon({"--max-silent-seconds", "2"});
    const Probe probe(daemon);
    Aftermath aftermath(probe, daemon.address());
    const double threads = probe.threads();
    auto ends = ends_of_silent(daemon, path, kCalls, [&] { EXPECT_LT(probe.threads(), threads + 16); });
    EXPECT_GE(ends[grpc::RESOURCE_EXHAUSTED], kCalls - kMax);  // the oldest were evicted for newer ones
    EXPECT_GT(ends[grpc::DEADLINE_EXCEEDED], 0);
    EXPECT_EQ(ends[grpc::DEADLINE_EXCEEDED] + ends[grpc::RESOURCE_EXHAUSTED], kCalls);
    aftermath.expect_unharmed();
  }
}

TEST(SilentCalls, OfThoseWhoWatchHealthTheOldestGo) {
  constexpr int kWatches = 80, kMax = 64;  // of one host
  DaemonProcess daemon;
  const Probe probe(daemon);
  Aftermath aftermath(probe, daemon.address());
  auto channel = channel_to(daemon.address(), 78);
  std::deque<RawStream> watches;
  std::string bytes;
  for (int i = 0; i < kWatches; ++i) {
    watches.emplace_back(channel, kHealthWatch);
    ASSERT_TRUE(watches.back().write({}) && watches.back().read(&bytes)) << i;
    EXPECT_EQ(bytes, std::string("\x08\x01")) << "SERVING";
  }
  for (int i = 0; i < kWatches - kMax; ++i) EXPECT_EQ(watches[i].finish().error_code(), grpc::RESOURCE_EXHAUSTED) << i;
  watches.clear();
  channel.reset();  // its connection is one of the daemon's descriptors
  aftermath.expect_unharmed();
}

TEST(SilentCalls, OfReflectionWhoDoNotReadEndToo) {
  constexpr int kQuestions = 1000;  // whose answers exceed the buffers of a client that does not read
  DaemonProcess daemon({"--max-silent-seconds", "0.5"});
  RawStream call(daemon.channel(), kReflection);
  grpc::reflection::v1::ServerReflectionRequest request;
  request.set_file_containing_symbol("collided.v1.CollisionService");
  for (int i = 0; i < kQuestions; ++i) ASSERT_TRUE(call.write(request.SerializeAsString()));
  eventually("the call is ended",
             [&] { return daemon.log().find("the client did not take its answer") != std::string::npos; });
}

TEST(Reflection, IsBehindTheTokenUnlessItIsOpen) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("collided-reflection-" + std::to_string(getpid()))).string();
  std::ofstream(path) << "[[tokens]]\nname = \"alice\"\ntoken = \"a-token-of-the-tests\"\n";
  const auto ask = [](const DaemonProcess& daemon, const RawStream::Metadata& metadata) {
    return raw_call(daemon.channel(), kReflection, list_services(), metadata).error_code();
  };
  {
    DaemonProcess daemon({"--tokens-file", path});
    EXPECT_EQ(ask(daemon, {}), grpc::UNAUTHENTICATED);
    EXPECT_EQ(ask(daemon, {{"authorization", "Bearer a-token-of-the-tests"}}), grpc::OK);
  }
  {
    DaemonProcess daemon({"--tokens-file", path, "--open-reflection"});
    EXPECT_EQ(ask(daemon, {}), grpc::OK);
  }
  std::filesystem::remove(path);
}

TEST(Reflection, AnswersBothVersions) {
  DaemonProcess daemon;
  for (const std::string version : {"v1", "v1alpha"}) {
    RawStream call(daemon.channel(), "/grpc.reflection." + version + ".ServerReflection/ServerReflectionInfo");
    std::string bytes;
    ASSERT_TRUE(call.write(list_services()) && call.read(&bytes));
    grpc::reflection::v1::ServerReflectionResponse list, response;
    ASSERT_TRUE(list.ParseFromString(bytes));
    EXPECT_EQ(list.list_services_response().service_size(), 4);
    for (const auto& service : list.list_services_response().service()) {
      if (!service.name().starts_with("grpc.reflection.") && !service.name().starts_with("collided.")) continue;
      grpc::reflection::v1::ServerReflectionRequest request;
      request.set_file_containing_symbol(service.name());
      ASSERT_TRUE(call.write(request.SerializeAsString()) && call.read(&bytes) && response.ParseFromString(bytes));
      EXPECT_GT(response.file_descriptor_response().file_descriptor_proto_size(), 0) << service.name();
    }
    call.writes_done();
    EXPECT_TRUE(call.finish().ok());
  }
}

}  // namespace
}  // namespace collided::test
