// Clients that disconnect, lag, flood, or write where the daemon reads: others and the scenes are unaffected.
#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <thread>

#include "tests/server/transport/local/serving.hpp"

namespace collided::server {
namespace {

using test::first_frame;
using test::tip_frame;

class HostileLocal : public testing::Test {
 protected:
  void expect_all_left(const std::string& scene) {
    EXPECT_TRUE(eventually([&] { return serving_.server().connections() == 0; }));
    EXPECT_TRUE(eventually([&] { return serving_.scene(scene)->record().stream() == nullptr; }));
    EXPECT_EQ(serving_.host().usage().streams(), 0u);
  }

  Serving serving_{{.open_seconds = 10, .take_seconds = 0.3}};
};

// A frame may be refused or answered, but never by positions written after the check.
TEST_F(HostileLocal, WritesWhileTheFrameIsInWork) {
  LocalStream stream(serving_.path(), serving_.make_scene());
  test::expect_tip_contact(stream.ask_shared(first_frame(2)), 2);
  std::atomic<bool> is_over = false;
  std::thread scribbler([&] {
    const auto nan = std::numeric_limits<float>::quiet_NaN();
    auto* const values = reinterpret_cast<volatile float*>(stream.memory().data());
    for (unsigned i = 0; !is_over; ++i) values[i % 18] = i % 7 == 0 ? nan : static_cast<float>(i % 3);
  });
  int refused = 0, answered = 0;
  for (uint64_t id = 2; id < 500; ++id) {
    const auto answer = stream.ask(test::shared_frame(tip_frame(id, 2), stream.memory()));
    refused += answer.error.has_value();
    answered += answer.done.has_value();
    if (answer.error) {
      EXPECT_EQ(answer.error->code(), 3) << answer.error->message();
    }
    for (const auto& chunk : answer.chunks)
      for (size_t i = 0; i < chunk.count(); ++i) {
        double toi = -1;
        std::memcpy(&toi, chunk.toi().data() + i * sizeof(toi), sizeof(toi));
        EXPECT_TRUE(toi >= 0 && toi <= 1) << toi;
      }
  }
  is_over = true;
  scribbler.join();
  EXPECT_EQ(refused + answered, 498);
  test::expect_tip_contact(stream.ask_shared(tip_frame(1000, 3)), 3);
}

TEST_F(HostileLocal, WritesNaNRightAfterSending) {
  LocalStream stream(serving_.path(), serving_.make_scene());
  test::expect_tip_contact(stream.ask_shared(first_frame(2)), 2);
  const std::string nan = test::pack(std::vector<float>(18, std::numeric_limits<float>::quiet_NaN()));
  for (uint64_t id = 2; id < 200; ++id) {
    stream.raw().send(test::shared_frame(tip_frame(id, 2), stream.memory()));
    stream.memory().put(0, nan);
    const auto answer = stream.receive(id);
    if (answer.done) test::expect_tip_contact(answer, 2);
    ASSERT_TRUE(answer.done || answer.error);
  }
}

TEST_F(HostileLocal, FloodsBeyondItsCredits) {
  const std::string scene = serving_.make_scene();
  LocalStream stream(serving_.path(), scene, {.window = 2});
  test::expect_tip_contact(stream.ask_shared(first_frame(2)), 2);
  serving_.scene(scene)->worker().post([] { std::this_thread::sleep_for(std::chrono::milliseconds(300)); });
  uint64_t sent = 1;
  pb::LocalRequest request;
  for (;; ++sent) {
    *request.mutable_frame() = test::shared_frame(tip_frame(sent + 1, 2), stream.memory());
    if (!stream.raw().send(request.SerializeAsString(), {}, MSG_DONTWAIT)) break;
    ASSERT_LT(sent, 100'000u) << "nothing holds the client back";
    EXPECT_LE(serving_.scene(scene)->record().stream()->waiting(), 2u);
  }
  for (uint64_t id = 2; id <= sent; ++id) ASSERT_TRUE(stream.receive(id).done) << id;
}

TEST_F(HostileLocal, TakesNoAnswers) {
  const std::string scene = serving_.make_scene();
  {
    LocalStream stream(serving_.path(), scene, {.output = 0, .window = 16});
    ASSERT_TRUE(stream.opened());
    pb::LocalRequest request;
    *request.mutable_frame() = first_frame(2);
    for (uint64_t id = 2; stream.raw().send(request.SerializeAsString(), {}, 0) && id < 100'000; ++id)
      *request.mutable_frame() = tip_frame(id, 2);
    expect_all_left(scene);
  }
  LocalStream next(serving_.path(), scene);
  ASSERT_TRUE(next.opened());
  test::expect_tip_contact(next.ask_shared(tip_frame(200'000, 2)), 2);
}

TEST_F(HostileLocal, HangsUpAtAnyTime) {
  const std::string scene = serving_.make_scene();
  const size_t files = open_files();
  uint64_t id = 1;
  for (int round = 0; round < 50; ++round) {
    LocalStream stream(serving_.path(), scene, {.window = 4});
    if (!stream.opened()) continue;  // the previous one is not gone yet
    for (int i = 0; i < round % 4; ++i, ++id)
      stream.raw().send(test::shared_frame(id == 1 ? first_frame(2) : tip_frame(id, 2), stream.memory(), 1024 * i));
  }
  expect_all_left(scene);
  EXPECT_TRUE(eventually([&] { return open_files() == files; }));
}

TEST_F(HostileLocal, SendsGarbageInTheMiddle) {
  const std::string scene = serving_.make_scene();
  const size_t files = open_files();
  for (int round = 0; round < 4; ++round) {
    LocalStream stream(serving_.path(), scene);
    ASSERT_TRUE(stream.opened());
    if (round == 0) stream.raw().send("\x07garbage");
    if (round == 1) stream.raw().send(std::string(100'000, 'x'));
    if (round == 2) stream.raw().send(tip_frame(1, 2).SerializeAsString(), {stream.memory().file()});
    if (round == 3) stream.raw().send(test::open_request(scene, 0, 0));
    EXPECT_GT(stream.raw().closed().code(), 0) << round;
    expect_all_left(scene);
  }
  EXPECT_TRUE(eventually([&] { return open_files() == files; }));
}

TEST_F(HostileLocal, ConnectsOverAndOver) {
  const std::string scene = serving_.make_scene();
  const size_t files = open_files();
  for (int i = 0; i < 300; ++i) {
    const RawLocal raw(serving_.path());
    if (i % 3 == 1) raw.send("x");
    if (i % 3 == 2) raw.send(test::open_request(scene, 0, 0));
  }
  expect_all_left(scene);
  EXPECT_TRUE(eventually([&] { return open_files() == files; }));
}

TEST_F(HostileLocal, DoesNotKeepTheDaemonFromStopping) {
  const std::string scene = serving_.make_scene(), other = serving_.make_scene();
  const RawLocal silent(serving_.path());
  LocalStream idle(serving_.path(), scene), deaf(serving_.path(), other, {.output = 0, .window = 16});
  pb::LocalRequest request;
  *request.mutable_frame() = first_frame(2);
  for (uint64_t id = 2; deaf.raw().send(request.SerializeAsString(), {}, MSG_DONTWAIT); ++id)
    *request.mutable_frame() = tip_frame(id, 2);
  serving_.server().stop();
  EXPECT_EQ(idle.raw().closed().code(), 14);
  EXPECT_EQ(serving_.server().connections(), 0u);
}

}  // namespace
}  // namespace collided::server
