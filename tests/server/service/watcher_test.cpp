// Which frames a watcher is shown, without gRPC.
#include "server/service/watcher.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "server/errors.hpp"
#include "server/frames/answer.hpp"
#include "server/frames/log.hpp"
#include "server/frames/run.hpp"
#include "tests/server/hand_clock.hpp"
#include "tests/server/scenes/tiny_scene.hpp"

namespace collided::server {
namespace {

class RecordingWatch final : public WatchSink {
 public:
  void show(WatchedUpdate update) override { shown.push_back(std::move(update)); }
  void ended(const std::exception_ptr&) override { ++ends; }
  void reserve(uint64_t message_bytes) override { reserved = message_bytes; }

  std::vector<WatchedUpdate> shown;
  int ends = 0;
  uint64_t reserved = 0;
};

class WatcherTest : public testing::Test {
 protected:
  std::shared_ptr<Watcher> watch(WatchOptions options = {}) {
    auto watcher = std::make_shared<Watcher>(scene_.scene(), std::move(options), scene_->plan(), sink_);
    scene_->record().begin_watch(watcher);
    return watcher;
  }
  void answer(uint64_t id, float depth = 2) {
    PendingFrame frame = tip_frame(id, depth);
    scene_->worker().post([&] {
      auto answered = run_frame(*scene_, frame, {});
      encode_contacts(*scene_, answered, kMaxChunkBytes, kMaxChunkBytes, [](auto, auto) {});
      tell_answered(*scene_, answered, {});
    });
    scene_->worker().flush();
  }
  void get_ready(Watcher& watcher) {
    watcher.taken();
    watcher.ready();
    scene_->worker().flush();
  }
  /// Frame ids, each with the number of frames before it that were skipped.
  std::vector<std::pair<uint64_t, uint64_t>> shown() const {
    std::vector<std::pair<uint64_t, uint64_t>> out;
    for (const auto& update : sink_->shown) out.emplace_back(update.frame->frame_id, update.skipped);
    return out;
  }
  using Shown = std::vector<std::pair<uint64_t, uint64_t>>;

  const HandClock clock_;
  SceneBench bench_{64, Turns::Options{.concurrent = 1, .now = clock_.now()}};
  const SceneUse scene_ = bench_.add();
  const std::shared_ptr<RecordingWatch> sink_ = std::make_shared<RecordingWatch>();
};

TEST_F(WatcherTest, OneThatIsNotReadyKeepsTheLatestFrame) {
  const auto watcher = watch();
  for (uint64_t id = 1; id <= 3; ++id) answer(id);
  EXPECT_EQ(shown(), Shown{});
  get_ready(*watcher);
  EXPECT_EQ(shown(), (Shown{{3, 2}}));
  get_ready(*watcher);  // nothing new
  EXPECT_EQ(shown(), (Shown{{3, 2}}));
  answer(5);
  answer(6);
  EXPECT_EQ(shown(), (Shown{{3, 2}, {5, 0}}));
  get_ready(*watcher);
  EXPECT_EQ(shown(), (Shown{{3, 2}, {5, 0}, {6, 0}}));
  EXPECT_EQ(bench_.observer.count_of(CounterId::kNotShownFrames), 2);
}

TEST_F(WatcherTest, AnIntervalCountsFromTheLastFrameShown) {
  const auto watcher = watch({.frame_interval = 3});
  get_ready(*watcher);
  for (uint64_t id = 1; id <= 4; ++id) answer(id);
  get_ready(*watcher);
  EXPECT_EQ(shown(), (Shown{{3, 2}}));
  answer(5);
  answer(6);
  EXPECT_EQ(shown(), (Shown{{3, 2}, {6, 2}}));
}

TEST_F(WatcherTest, WatchersShareTheFrameAndThePositions) {
  WatchOptions options{.max_contacts = 10, .meshes = {1}, .samples = {1, {{3, 1, 3}}}};
  const auto first = watch(options), second = watch(options);
  get_ready(*first);
  get_ready(*second);
  answer(1, 4);
  ASSERT_EQ(sink_->shown.size(), 2u);
  EXPECT_EQ(sink_->shown[0].frame, sink_->shown[1].frame);
  ASSERT_EQ(sink_->shown[0].positions.size(), 1u);
  EXPECT_EQ(sink_->shown[0].positions[0], sink_->shown[1].positions[0]);
  const auto expected = tip_positions(1 - 4);
  EXPECT_EQ(*sink_->shown[0].positions[0],
            std::string(reinterpret_cast<const char*>(expected.data()), sizeof(expected)));
  ASSERT_EQ(sink_->shown[0].frame->done.contacts_size(), 1);
  EXPECT_EQ(sink_->shown[0].frame->done.contacts(0).count(), 1u);
}

TEST_F(WatcherTest, AMessageIsUnreadUntilItIsTaken) {
  const auto watcher = watch();
  clock_.move(std::chrono::seconds(2));
  EXPECT_EQ(watcher->unread_seconds(), 2);  // the answer to the request
  get_ready(*watcher);
  clock_.move(std::chrono::seconds(3));
  EXPECT_EQ(watcher->unread_seconds(), 0);
  answer(1);
  clock_.move(std::chrono::seconds(4));
  EXPECT_EQ(watcher->unread_seconds(), 4);
  watcher->taken();
  EXPECT_EQ(watcher->unread_seconds(), 0);
}

TEST_F(WatcherTest, IsToldOnceThatItsSceneIsGoneAndShownNothingAfterwards) {
  const auto watcher = watch();
  get_ready(*watcher);
  bench_.scenes.remove(client(), scene_->id());
  EXPECT_EQ(sink_->ends, 1);
  watcher->end(nullptr);
  EXPECT_EQ(sink_->ends, 1);
  EXPECT_EQ(scene_->record().watchers().size(), 0u);
  get_ready(*watcher);
  EXPECT_EQ(shown(), Shown{});
  EXPECT_THROW(watch(), NotFound);
}

TEST_F(WatcherTest, PositionsThatCannotBeReadEndTheWatchAndNotTheFrame) {
  const auto watcher = watch({.meshes = {1}, .samples = {1, {{3, 1, uint64_t{1} << 60}}}});
  get_ready(*watcher);
  answer(1);
  EXPECT_EQ(sink_->ends, 1);
  EXPECT_EQ(bench_.observer.answers, 1);
  EXPECT_EQ(bench_.observer.refusals, 0);
  answer(2);
  EXPECT_EQ(scene_->snapshot().last_frame_id, 2u);
}

}  // namespace
}  // namespace collided::server
