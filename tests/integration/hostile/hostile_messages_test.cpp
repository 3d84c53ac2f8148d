// Hostile messages: their expansion is bounded, and nothing is read from unknown callers.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "tests/integration/support/bystander.hpp"
#include "tests/integration/support/client_channel.hpp"
#include "tests/integration/support/peers/raw_stream.hpp"

namespace collided::test {
namespace {

constexpr size_t kLarge = size_t{63} << 20;

std::string varint(uint64_t value) {
  std::string out;
  for (; value >= 0x80; value >>= 7) out += static_cast<char>(value | 0x80);
  return out + static_cast<char>(value);
}

std::string field(uint32_t number, const std::string& bytes) {
  return varint(number << 3 | 2) + varint(bytes.size()) + bytes;
}

/// That many bytes of small fields, one after the other.
std::string repeated(const std::string& small, size_t bytes) {
  std::string out;
  out.reserve(bytes + small.size());
  while (out.size() < bytes) out += small;
  return out;
}

std::string empty_updates(size_t bytes) { return repeated(field(3, ""), bytes); }

/// A DetectFrameRequest.
std::string frame_of(const std::string& scene, const std::string& frame) { return field(1, scene) + field(2, frame); }

/// Its memory must not grow by more MiB than this while it lives.
class PeakLimit {
 public:
  PeakLimit(const Probe& probe, double mebibytes)
      : probe_(probe), limit_(probe.resident_bytes() + memory_limit(mebibytes)) {}
  ~PeakLimit() { EXPECT_LT(probe_.peak_resident_bytes() / (1 << 20), limit_ / (1 << 20)) << "MiB"; }

 private:
  const Probe& probe_;
  const double limit_;
};

const RawStream::Metadata kAlice = {{"authorization", "Bearer " + token_of("alice")}};

TEST(HostileMessages, NothingIsReadOfACallerWithoutAToken) {
  const TokensFile tokens({{"alice"}});
  DaemonProcess daemon({"--tokens-file", tokens.path()});
  const Probe probe(daemon);
  const auto channel = daemon.channel();
  ASSERT_TRUE(raw_call(channel, method_path("ListScenes"), "", kAlice).ok());
  const std::string hostile = frame_of("scene", empty_updates(kLarge));
  {
    const PeakLimit limit(probe, 96);  // less than two of the messages
    for (const char* method : {"DetectFrame", "CreateScene", "GetServerInfo", "UploadMesh", "StreamFrames"})
      for (int i = 0; i < 3; ++i)
        EXPECT_EQ(raw_call(channel, method_path(method), hostile).error_code(), grpc::UNAUTHENTICATED) << method;
  }
  EXPECT_TRUE(raw_call(channel, method_path("ListScenes"), "", kAlice).ok());
}

// Each of them took 2.9 GB.
TEST(HostileMessages, WhatAMessageUnfoldsToIsBounded) {
  DaemonProcess daemon;
  const Probe probe(daemon);
  Aftermath aftermath(probe, daemon.address());
  {
    const PeakLimit limit(probe, 256);
    std::vector<std::thread> attackers;
    for (const std::string& small : {field(3, ""), varint(1000 << 3) + '\1', field(3, field(2, ""))})
      attackers.emplace_back([&daemon, small, number = static_cast<int>(attackers.size())] {
        const auto status = raw_call(channel_to(daemon.address(), 10 + number), method_path("DetectFrame"),
                                     frame_of("scene", repeated(small, kLarge)));
        EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED) << status.error_message();
        EXPECT_NE(status.error_message().find("fields"), std::string::npos) << status.error_message();
      });
    for (auto& attacker : attackers) attacker.join();
  }
  aftermath.expect_unharmed();
}

TEST(HostileMessages, OtherMessagesAreBoundedToo) {
  DaemonProcess daemon;
  const auto channel = daemon.channel();
  const std::string meshes = field(2, repeated(field(11, ""), 4 << 20));
  const std::string kinds = field(2, field(8, std::string(8 << 20, '\1')));
  const std::string unknown = repeated(varint(1000 << 3) + '\1', 4 << 20);
  for (const std::string& request : {meshes, kinds, unknown})
    EXPECT_EQ(raw_call(channel, method_path("CreateScene"), request).error_code(), grpc::RESOURCE_EXHAUSTED);
  for (const char* method : {"GetServerInfo", "EstimateScene", "GetScene", "GetMesh", "ListScenes", "DeleteScene",
                             "UploadMesh", "StreamFrames"}) {
    const auto status = raw_call(channel, method_path(method), unknown);
    EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED) << method << ": " << status.error_message();
  }
}

// gRPC would expand it before it could be checked.
TEST(HostileMessages, CompressedMessagesAreNotTaken) {
  DaemonProcess daemon;
  const Probe probe(daemon);
  const PeakLimit limit(probe, 32);
  const auto status =
      raw_call(daemon.channel(), method_path("DetectFrame"), std::string(kLarge, '\0'), {}, GRPC_COMPRESS_GZIP);
  EXPECT_EQ(status.error_code(), grpc::UNIMPLEMENTED) << status.error_message();
}

TEST(HostileMessages, AFrameOfManyEmptyUpdatesIsRefusedByItsId) {
  DaemonProcess daemon;
  const Probe probe(daemon);
  Aftermath aftermath(probe, daemon.address());
  {
    const PeakLimit limit(probe, 128);
    const auto channel = daemon.channel();
    auto stub = pb::CollisionService::NewStub(channel);
    const std::string scene = make_scene(*stub, tip_request());
    RawStream stream(channel, method_path("StreamFrames"));
    std::string answer;
    pb::StreamFramesResponse response;
    ASSERT_TRUE(stream.write(Stream::opening(scene).SerializeAsString()) && stream.read(&answer));
    for (const auto& [id, small] : {std::pair<uint64_t, std::string>{1, field(3, "")}, {2, field(3, field(2, ""))}}) {
      ASSERT_TRUE(stream.write(field(2, varint(1 << 3) + varint(id) + repeated(small, 20 << 20))));
      ASSERT_TRUE(stream.read(&answer) && response.ParseFromString(answer));
      EXPECT_EQ(response.frame_id(), id);
      EXPECT_EQ(response.error().field(), "frame.updates") << response.ShortDebugString();
    }
    pb::StreamFramesRequest good;
    *good.mutable_frame() = first_frame(2);
    good.mutable_frame()->set_frame_id(3);
    ASSERT_TRUE(stream.write(good.SerializeAsString()) && stream.read(&answer) && response.ParseFromString(answer));
    EXPECT_TRUE(response.has_done()) << response.ShortDebugString();
    EXPECT_TRUE(delete_scene(*stub, scene).ok());
  }
  aftermath.expect_unharmed();
}

TEST(HostileMessages, FieldsThatNobodyKnowsEndAStreamWhereTheyAreMany) {
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const std::string unknown = repeated(varint(1000 << 3) + '\1', 1 << 20);
  const std::string sparse = field(3, field(2, unknown)), update = field(3, unknown);
  for (const std::string& frame : {unknown, update, sparse}) {
    RawStream stream(daemon.channel(), method_path("StreamFrames"));
    std::string answer;
    ASSERT_TRUE(stream.write(Stream::opening(make_scene(*stub, tip_request())).SerializeAsString()));
    ASSERT_TRUE(stream.read(&answer));
    stream.write(field(2, varint(1 << 3) + '\1' + frame));
    const auto status = stream.finish();
    EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED) << status.error_message();
    EXPECT_NE(status.error_message().find("fields"), std::string::npos) << status.error_message();
  }
}

TEST(HostileMessages, MalformedOnesAreNamed) {
  DaemonProcess daemon;
  const auto channel = daemon.channel();
  const std::pair<const char*, const char*> messages[] = {{"GetServerInfo", "GetServerInfoRequest"},
                                                          {"CreateScene", "CreateSceneRequest"},
                                                          {"EstimateScene", "EstimateSceneRequest"},
                                                          {"GetScene", "GetSceneRequest"},
                                                          {"GetMesh", "GetMeshRequest"},
                                                          {"ListScenes", "ListScenesRequest"},
                                                          {"DeleteScene", "DeleteSceneRequest"},
                                                          {"DetectFrame", "DetectFrameRequest"},
                                                          {"UploadMesh", "UploadMeshRequest"},
                                                          {"StreamFrames", "request"}};
  for (const auto& [method, message] : messages)
    for (const char* bytes : {"\xff", "\x0a\x05xy", "\x0b", "\x0f"})
      expect_field(raw_call(channel, method_path(method), bytes), grpc::INVALID_ARGUMENT, message);
  expect_field(raw_call(channel, method_path("DetectFrame"), field(2, field(3, "\xff"))), grpc::INVALID_ARGUMENT,
               "DetectFrameRequest.frame.updates");
  // Text that is not UTF-8.
  expect_field(raw_call(channel, method_path("GetScene"), field(1, "\xff\xfe")), grpc::INVALID_ARGUMENT,
               "GetSceneRequest");
}

TEST(HostileMessages, ACallWithoutAMessageIsToldSo) {
  DaemonProcess daemon;
  RawStream call(daemon.channel(), method_path("GetScene"));
  call.writes_done();
  expect_field(call.finish(), grpc::INVALID_ARGUMENT, "request");
}

TEST(HostileMessages, MethodsThatAreNotThereAreNamedButNotCounted) {
  DaemonProcess daemon;
  const Probe probe(daemon);
  const auto status = raw_call(daemon.channel(), method_path("Frobnicate"), "");
  EXPECT_EQ(status.error_code(), grpc::UNIMPLEMENTED);
  EXPECT_NE(status.error_message().find("Frobnicate"), std::string::npos) << status.error_message();
  EXPECT_EQ(http_get(daemon.http_address(), "/metrics").find("Frobnicate"), std::string::npos);
}

TEST(HostileMessages, AMessagePastTheLimitNamesTheOption) {
  DaemonProcess daemon({"--max-message-mb", "1"});
  const auto channel = daemon.channel();
  for (const char* method : {"DetectFrame", "UploadMesh", "StreamFrames"}) {
    const auto status = raw_call(channel, method_path(method), std::string((1 << 20) + 1, '\0'));
    EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED) << method;
    EXPECT_NE(status.error_message().find("max-message-mb"), std::string::npos) << status.error_message();
    EXPECT_NE(status.error_message().find("1048577"), std::string::npos) << status.error_message();
  }
}

TEST(HostileMessages, PageTokensAreThoseOfAnswers) {
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const auto list = [&](const std::string& token) {
    pb::ListScenesRequest request;
    request.set_page_token(token);
    return raw_call(daemon.channel(), method_path("ListScenes"), request.SerializeAsString());
  };
  const std::string id = make_scene(*stub, tip_request());
  for (const std::string& token : {std::string("zz"), id + "0", id.substr(1), std::string(32, 'g')})
    expect_field(list(token), grpc::INVALID_ARGUMENT, "page_token");
  EXPECT_TRUE(list(id).ok());
  EXPECT_TRUE(list(std::string(32, '0')).ok());  // of a scene that is gone
}

TEST(HostileMessages, TheLargestFrameIdLeavesTheSceneAsItWas) {
  DaemonProcess daemon;
  auto stub = pb::CollisionService::NewStub(daemon.channel());
  const std::string scene = make_scene(*stub, tip_request());
  for (const uint64_t id : {~uint64_t{0}, uint64_t{1} << 63}) {
    pb::Frame frame = first_frame(2);
    frame.set_frame_id(id);
    const auto status = detect(*stub, scene, frame);
    expect_field(status, grpc::INVALID_ARGUMENT, "frame.frame_id");
    EXPECT_NE(status.error_message().find(std::to_string(id)), std::string::npos) << status.error_message();
    EXPECT_NE(status.error_message().find("9223372036854775807"), std::string::npos) << status.error_message();
  }
  EXPECT_TRUE(detect(*stub, scene, first_frame(2)).ok());
}

TEST(HostileMessages, RefusedCallersDoNotFillTheLog) {
  constexpr int kCalls = 1000;
  const TokensFile tokens({{"alice"}});
  DaemonProcess daemon({"--tokens-file", tokens.path()});
  const Probe probe(daemon);
  const auto channel = daemon.channel();
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kCalls; ++i) raw_call(channel, method_path(i % 2 ? "GetScene" : "StreamFrames"), "");
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_EQ(probe.rejected("UNAUTHENTICATED"), kCalls);
  const std::string log = daemon.log();
  EXPECT_LT(std::count(log.begin(), log.end(), '\n'), 50 + 25 * (seconds.count() + 1));
  EXPECT_NE(log.find("call refused"), std::string::npos);
}

}  // namespace
}  // namespace collided::test
