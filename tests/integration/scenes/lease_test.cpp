// Lifetimes of unused scenes and streams, and idempotent creation.
#include <gtest/gtest.h>

#include <optional>
#include <set>
#include <thread>

#include "tests/integration/support/layers.hpp"
#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

class Lease : public testing::Test {
 protected:
  static pb::CreateSceneRequest with_lease(double seconds) {
    auto request = tip_request();
    request.set_lease_seconds(seconds);
    return request;
  }

  DaemonProcess daemon_{{"--lease-seconds", "1", "--max-lease-seconds", "1000"}};
  Probe probe_{daemon_};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

TEST_F(Lease, ASceneThatNobodyUsesIsDeletedWithItsMemory) {
  const auto scene = made_scene(*stub_, tip_request());
  EXPECT_EQ(scene.lease_seconds(), 1);  // the daemon's
  EXPECT_TRUE(probe_.scenes_become(0));
  EXPECT_TRUE(probe_.becomes("collided_device_bytes", 0));
  EXPECT_EQ(get_scene(*stub_, scene.scene_id()).error_code(), grpc::NOT_FOUND);
  EXPECT_EQ(Stream(*stub_, scene.scene_id(), 0, scene.resume_token()).finish().error_code(), grpc::NOT_FOUND);
}

TEST_F(Lease, ASceneMayAskForALongerOne) {
  EXPECT_EQ(made_scene(*stub_, with_lease(1000)).lease_seconds(), 1000);
  make_scene(*stub_, with_lease(0.1));
  EXPECT_TRUE(probe_.scenes_become(1));
}

TEST_F(Lease, ALeaseThatIsTooLongOrNoNumberIsRefused) {
  expect_field(create_scene(*stub_, with_lease(1000.5)), grpc::RESOURCE_EXHAUSTED, "lease_seconds");
  for (const double bad : {-1.0, 0.0 / 0.0, 1.0 / 0.0}) {
    const auto status = create_scene(*stub_, with_lease(bad));
    EXPECT_TRUE(status.error_code() == grpc::INVALID_ARGUMENT || bad > 0) << status.error_message();
    EXPECT_FALSE(status.ok());
    EXPECT_EQ(details_of(status).fields, std::vector<std::string>{"lease_seconds"});
  }
}

// The scene lives until a stream holds it, or long enough for another try.
TEST_F(Lease, AStreamKeepsItsScene) {
  std::string id;
  std::optional<Stream> stream;
  eventually("a stream is faster than its scene's lease", [&] {
    id = make_scene(*stub_, with_lease(0.2));
    stream.emplace(*stub_, id);
    return stream->opened().has_value();
  });
  expect_tip_contact(stream->ask(first_frame(2)), 2);
  std::this_thread::sleep_for(std::chrono::milliseconds(1000));  // several leases
  expect_tip_contact(stream->ask(tip_frame(2, 2)), 2);
  EXPECT_TRUE(stream->finish().ok());
  EXPECT_TRUE(probe_.scenes_become(0));
}

TEST(IdleStream, EndsAndThenItsSceneDoes) {
  DaemonProcess daemon({"--lease-seconds", "0.2", "--max-idle-seconds", "0.1"});
  const Probe probe(daemon);
  const auto stub = pb::CollisionService::NewStub(daemon.channel());
  auto request = tip_request();
  request.set_lease_seconds(10);
  const auto id = make_scene(*stub, request);
  Stream stream(*stub, id);
  expect_quota(stream.wait_end(), "max_idle_seconds", "scene:" + id);
  EXPECT_EQ(probe.streams(), 0);
  EXPECT_TRUE(delete_scene(*stub, id).ok());
  make_scene(*stub, tip_request());
  EXPECT_TRUE(probe.scenes_become(0));
}

class RequestId : public testing::Test {
 protected:
  static pb::CreateSceneRequest with_id(const std::string& id) {
    auto request = tip_request();
    request.set_request_id(id);
    return request;
  }

  DaemonProcess daemon_;
  Probe probe_{daemon_};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

TEST_F(RequestId, ARepeatedRequestHasTheSameScene) {
  const auto first = made_scene(*stub_, with_id("one")), again = made_scene(*stub_, with_id("one"));
  EXPECT_EQ(first.scene_id(), again.scene_id());
  EXPECT_EQ(first.resume_token(), again.resume_token());
  EXPECT_NE(first.scene_id(), make_scene(*stub_, with_id("two")));
  EXPECT_EQ(list_scenes(*stub_).size(), 2u);
}

TEST_F(RequestId, AnotherSpecIsRefused) {
  const auto id = make_scene(*stub_, with_id("one"));
  auto other = with_id("one");
  other.mutable_spec()->mutable_meshes(1)->set_triangles(pack<uint32_t>({0, 2, 1}));
  expect_field(create_scene(*stub_, other), grpc::ALREADY_EXISTS, "request_id");
  EXPECT_EQ(list_scenes(*stub_).size(), 1u);
  EXPECT_TRUE(delete_scene(*stub_, id).ok());
  EXPECT_NE(make_scene(*stub_, other), id);  // the id is free again
}

TEST_F(RequestId, OneThatIsTooLongIsRefused) {
  make_scene(*stub_, with_id(std::string(64, 'x')));
  expect_field(create_scene(*stub_, with_id(std::string(65, 'x'))), grpc::INVALID_ARGUMENT, "request_id");
}

TEST_F(RequestId, NoneMakesASceneEachTime) {
  EXPECT_NE(make_scene(*stub_, with_id("")), make_scene(*stub_, with_id("")));
}

TEST_F(RequestId, RepeatsAtOnceMakeOneScene) {
  constexpr int kRequests = 8;
  auto request = layers_request(60);
  request.set_request_id("same");
  std::vector<std::string> ids(kRequests);
  std::vector<std::thread> threads;
  for (int i = 0; i < kRequests; ++i)
    threads.emplace_back([&, i] {
      auto stub = pb::CollisionService::NewStub(channel_to(daemon_.address(), i));
      ids[i] = make_scene(*stub, request);
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(std::set<std::string>(ids.begin(), ids.end()).size(), 1u);
  EXPECT_EQ(probe_.scenes(), 1);
}

}  // namespace
}  // namespace collided::test
