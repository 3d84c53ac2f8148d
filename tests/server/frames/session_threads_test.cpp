// Frame streams used by many threads at once: for the thread sanitizer, and for invariants under any order.
#include <gtest/gtest.h>

#include <thread>

#include "tests/server/frames/recording_sink.hpp"
#include "tests/server/scenes/tiny_scene.hpp"

namespace collided::server {
namespace {

using Events = RecordingSink::Events;

struct Stream {
  std::shared_ptr<RecordingSink> sink = std::make_shared<RecordingSink>();
  std::shared_ptr<FrameSession> session;
};

Stream take_over(const SceneUse& scene, Delivery delivery) {
  Stream stream;
  stream.session = FrameSession::open(scene, scene->identity().resume_token, delivery, stream.sink);
  return stream;
}

// Whether the ids of the events that begin with `what` increase.
bool rises(const Events& events, const std::string& what) {
  uint64_t last = 0;
  for (const auto& event : events) {
    if (!event.starts_with(what)) continue;
    const uint64_t id = std::stoull(event.substr(what.size()));
    if (id <= last) return false;
    last = id;
  }
  return true;
}

// Opens repeatedly with the token, each time with some frames, and leaves some streams to be taken over.
void stream_on(const SceneUse& scene, std::vector<Stream>& streams, std::atomic<uint64_t>& id, bool closes) {
  for (int i = 0; i < 10; ++i) {
    auto stream = take_over(scene, i % 2 == 0 ? Delivery::kLossless : Delivery::kLatestWins);
    for (int k = 0; k < 5; ++k) stream.session->submit(tip_frame(++id, 2));
    if (closes) stream.session->close();
    streams.push_back(std::move(stream));
  }
}

// What the daemon's other threads do to a scene's stream.
void look_on(const SceneUse& scene, const std::atomic<bool>& stop) {
  for (bool is_held = false; !stop; is_held = !is_held) {
    const auto stream = std::dynamic_pointer_cast<FrameSession>(scene->record().stream());
    if (!stream) continue;
    stream->hold(is_held);
    stream->announce_stop(1);
    EXPECT_GE(stream->idle_seconds(), 0);
    EXPECT_LE(stream->waiting(), 5u);
    EXPECT_LE(scene->snapshot().last_frame_id, 100u);
    std::this_thread::yield();
  }
}

TEST(FrameSessionThreads, TakeOversAndClosesKeepTheOrderOfEachStream) {
  SceneBench bench(64, 2);
  const SceneUse scenes[] = {bench.add(), bench.add()};
  std::atomic<bool> stop = false;
  std::atomic<uint64_t> ids[2] = {0, 0};
  std::array<std::vector<Stream>, 4> streams;
  std::vector<std::thread> threads, watchers;
  for (size_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] { stream_on(scenes[t / 2], streams[t], ids[t / 2], t % 2 == 0); });
  for (const auto& scene : scenes) watchers.emplace_back([&] { look_on(scene, stop); });
  for (auto& thread : threads) thread.join();
  stop = true;
  for (auto& thread : watchers) thread.join();
  for (const auto& scene : scenes) bench.scenes.remove(client(), scene->id());
  for (const auto& scene : scenes) scene->worker().flush();
  for (const auto& of_thread : streams)
    for (const auto& stream : of_thread) {
      EXPECT_TRUE(stream.session->is_closed());
      EXPECT_TRUE(rises(stream.sink->events(), "answered "));
    }
}

TEST(FrameSessionThreads, EveryFrameOfSeveralScenesIsAnsweredInOrder) {
  constexpr uint64_t kFrames = 40;
  SceneBench bench(64, 2);
  std::vector<Stream> streams;
  for (int i = 0; i < 4; ++i) streams.push_back(take_over(bench.add(), Delivery::kLossless));
  std::vector<std::thread> threads;
  for (auto& stream : streams)
    threads.emplace_back([&] {
      for (uint64_t id = 1; id <= kFrames; ++id) stream.session->submit(tip_frame(id, 2));
    });
  for (auto& thread : threads) thread.join();
  for (auto& stream : streams) {
    const auto events = stream.sink->wait_for(1 + kFrames);
    EXPECT_EQ(events.size(), 1 + kFrames);
    EXPECT_TRUE(rises(events, "answered "));
    stream.session->close();
  }
}

TEST(FrameSessionThreads, OneOfManyOpensAStreamAtATime) {
  SceneBench bench;
  const SceneUse scene = bench.add();
  std::atomic<int> open = 0, most = 0, opened = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 6; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 50; ++i) try {
          const auto session = FrameSession::open(scene, "", Delivery::kLossless, std::make_shared<RecordingSink>());
          ++opened;
          if (++open > 1) ++most;
          --open;
          session->close();
        } catch (const FailedPrecondition&) {
          std::this_thread::yield();
        }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_GT(opened, 0);
  EXPECT_EQ(most, 0);
  EXPECT_EQ(scene->record().stream(), nullptr);
}

}  // namespace
}  // namespace collided::server
