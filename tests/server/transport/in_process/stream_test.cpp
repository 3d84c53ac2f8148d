// Frames of a caller in this process, from one thread and from several. No gRPC thread runs here, so that the thread
// sanitizer sees only ours.
#include "server/transport/in_process/stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <future>
#include <semaphore>

#include "tests/server/transport/local/serving.hpp"

namespace collided::server {
namespace {

using Arrival = InProcessStream::Arrival;
using test::first_frame;
using test::tip_frame;

constexpr auto kForEver = InProcessStream::Time::max();

class InProcessFrames : public testing::Test {
 protected:
  explicit InProcessFrames(const Config& config = Serving::cpu_config()) : serving_({}, config) {}
  std::shared_ptr<InProcessStream> open(const std::string& scene, uint32_t window = 2, const std::string& token = "") {
    pb::OpenStream open;
    open.set_scene_id(scene);
    open.set_window(window);
    open.set_resume_token(token);
    auto stream = InProcessStream::open(open, {serving_.host(), serving_.authenticator(), serving_.metrics()});
    EXPECT_TRUE(next(*stream).message.has_opened());
    return stream;
  }
  std::string token_of(const std::string& scene) { return serving_.scene(scene)->identity().resume_token; }
  static InProcessAnswer next(InProcessStream& stream) {
    InProcessAnswer answer;
    EXPECT_EQ(stream.read(answer, kForEver), Arrival::kMessage);
    return answer;
  }
  static pb::FrameDone ask(InProcessStream& stream, const pb::Frame& frame) {
    EXPECT_TRUE(stream.submit({frame, {}}));
    return next(stream).message.done();
  }

  Serving serving_;
};

std::span<const std::byte> at(const pb::SharedRange& range) {
  return {reinterpret_cast<const std::byte*>(range.offset()), range.size()};
}

// The frame's arrays are lent: what becomes of them afterwards does not matter.
TEST_F(InProcessFrames, AreCopiedAndTheirContactsAreNot) {
  const auto stream = open(serving_.make_scene());
  ask(*stream, first_frame(0.5));
  std::string start = test::pack_points(test::tip_points(1)), end = test::pack_points(test::tip_points(-1));
  end.resize(end.size() + 64);  // longer than what stays in the message
  pb::Frame frame;
  frame.set_frame_id(2);
  frame.add_updates()->set_mesh(1);
  EXPECT_TRUE(stream->submit({frame, {{std::as_bytes(std::span(start)), std::as_bytes(std::span(end)), {}}}}));
  std::ranges::fill(end, '\x7f');
  EXPECT_EQ(next(*stream).message.error().field(), "frame.updates[0].positions");
  const std::string fall = test::pack_points(test::tip_points(-1));
  const auto room = stream->input(fall.size());
  std::memcpy(room.data(), fall.data(), fall.size());
  frame.set_frame_id(3);
  EXPECT_TRUE(stream->submit({frame, {{std::as_bytes(std::span(start)), room, {}}}}));
  const InProcessAnswer answer = next(*stream);
  ASSERT_EQ(answer.message.done().contacts_size(), 1);
  const pb::SharedArrays& arrays = answer.message.done().contacts(0).shared();
  double time = 0;
  ASSERT_EQ(at(arrays.toi()).size(), sizeof time);
  std::memcpy(&time, at(arrays.toi()).data(), sizeof time);
  EXPECT_NEAR(time, 0.5, 1e-6);
  EXPECT_EQ(at(arrays.stencils()).size(), 16u);
}

TEST_F(InProcessFrames, EndOnceAllAreAnsweredAfterTheLast) {
  const auto stream = open(serving_.make_scene());
  EXPECT_TRUE(stream->submit({first_frame(2), {}}));
  stream->half_close();
  EXPECT_FALSE(stream->submit({tip_frame(2, 2), {}}));
  EXPECT_EQ(next(*stream).message.done().contact_count(), 1u);
  InProcessAnswer none;
  EXPECT_EQ(stream->read(none, kForEver), Arrival::kEnd);
  EXPECT_EQ(stream->end().code, grpc::StatusCode::OK);
}

TEST_F(InProcessFrames, EndWhereAnotherStreamTakesOver) {
  const std::string scene = serving_.make_scene();
  const auto stream = open(scene);
  ask(*stream, first_frame(2));
  const auto other = open(scene, 2, token_of(scene));
  InProcessAnswer none;
  EXPECT_EQ(stream->read(none, kForEver), Arrival::kEnd);
  EXPECT_EQ(stream->end().code, grpc::StatusCode::ABORTED);
  EXPECT_FALSE(stream->submit({tip_frame(2, 2), {}}));
  EXPECT_EQ(ask(*other, tip_frame(2, 2)).contact_count(), 1u);
}

TEST_F(InProcessFrames, GoOnAfterADeadlineHasPassed) {
  const auto stream = open(serving_.make_scene());
  InProcessAnswer none;
  EXPECT_EQ(stream->read(none, InProcessStream::Time::clock::now()), Arrival::kNothing);
  EXPECT_EQ(ask(*stream, first_frame(2)).contact_count(), 1u);
}

TEST_F(InProcessFrames, AreSentReadAndCancelledByThreeThreads) {
  constexpr int kWindow = 4, kMany = 1000;
  const std::string scene = serving_.make_scene();
  uint64_t id = 0;
  for (int round = 0; round < 10; ++round) {
    const auto stream = open(scene, kWindow, token_of(scene));
    std::counting_semaphore<> credits(kWindow);
    std::atomic<int> answered = 0;
    auto reader = std::async(std::launch::async, [&] {
      for (InProcessAnswer answer; stream->read(answer, kForEver) == Arrival::kMessage; ++answered) credits.release();
      credits.release(kMany);
    });
    auto sender = std::async(std::launch::async, [&] {
      do {
        credits.acquire();
        ++id;
      } while (stream->submit({id == 1 ? first_frame(2) : tip_frame(id, 2), {}}));
    });
    EXPECT_TRUE(eventually([&] { return answered > 3; }));
    stream->cancel();
    reader.get();
    sender.get();
    EXPECT_EQ(stream->end().code, grpc::StatusCode::CANCELLED);
  }
}

class SmallFrames : public InProcessFrames {
 protected:
  static Config config() {
    Config config = Serving::cpu_config();
    config.limits.max_message_bytes = 1000;
    return config;
  }
  SmallFrames() : InProcessFrames(config()) {}
};

TEST_F(SmallFrames, AreNotCopiedIfTheyAreTooLongForAny) {
  const auto stream = open(serving_.make_scene());
  ask(*stream, first_frame(0.5));
  pb::Frame frame;
  frame.set_frame_id(2);
  frame.add_updates()->set_mesh(1);
  const std::string endless(2000, '\0');
  EXPECT_TRUE(stream->submit({frame, {{{}, std::as_bytes(std::span(endless)), {}}}}));
  const InProcessAnswer answer = next(*stream);
  EXPECT_EQ(answer.message.error().code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_NE(answer.message.error().message().find("2048 bytes"), std::string::npos) << answer.message.error().message();
  EXPECT_THROW(stream->input(1'000'000), std::exception);
  EXPECT_EQ(ask(*stream, tip_frame(3, 2)).contact_count(), 1u);
}

}  // namespace
}  // namespace collided::server
