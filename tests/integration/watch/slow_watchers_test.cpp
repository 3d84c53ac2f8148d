// Watchers that read slowly or not at all: the frames go on, and memory is bounded.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/integration/support/layers.hpp"
#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/stream.hpp"
#include "tests/integration/support/watch.hpp"

namespace collided::test {
namespace {

constexpr uint32_t kSide = 120;  // 346 kB of positions

class SlowWatchers : public testing::Test {
 protected:
  pb::WatchSceneRequest with_positions() const {
    return watch_request(id_, [](auto& request) {
      request.add_position_meshes(0);
      request.set_max_contacts_per_kind(8192);
    });
  }
  void send_frames(uint64_t first, uint64_t last) {
    for (uint64_t frame = first; frame <= last; ++frame) {
      const auto answer = stream_.ask(layers_frame(frame, positions_));
      ASSERT_TRUE(answer.done) << frame;
    }
  }

  DaemonProcess daemon_{{"--max-idle-seconds", "1000"}};
  Probe probe_{daemon_};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
  std::unique_ptr<Stub> other_ = pb::CollisionService::NewStub(channel_to(daemon_.address(), 1));
  const std::string id_ = make_scene(*stub_, layers_request(kSide, 1000));
  const std::string positions_ = pack_points(layer_points(kSide, kLayersApart));
  Stream stream_{*stub_, id_};
};

TEST_F(SlowWatchers, OneThatReadsNothingLosesFramesAndSeesTheLatestOnceItReads) {
  constexpr uint64_t kFrames = 40;
  Watch watch(*other_, with_positions());
  ASSERT_TRUE(watch.opened());
  ASSERT_NO_FATAL_FAILURE(send_frames(1, kFrames));
  uint64_t last = 0, skipped = 0, shown = 0;
  while (last < kFrames) {
    const auto next = watch.next();
    ASSERT_TRUE(next);
    EXPECT_EQ(next->frame_id(), last + next->skipped_frames() + 1);
    EXPECT_TRUE(next->positions(0).positions() == positions_);
    last = next->frame_id();
    skipped += next->skipped_frames();
    ++shown;
  }
  EXPECT_GT(skipped, 0u);
  EXPECT_EQ(shown + skipped, kFrames);
  EXPECT_EQ(probe_.metric("collided_watch_skipped_frames_total"), static_cast<double>(skipped));
}

TEST_F(SlowWatchers, HoldNoMoreMemoryTheMoreFramesGoBy) {
  ASSERT_NO_FATAL_FAILURE(send_frames(1, 3));
  const double before = probe_.device_bytes();
  std::vector<std::unique_ptr<Watch>> watches;
  for (int i = 0; i < 4; ++i) watches.push_back(std::make_unique<Watch>(*other_, with_positions()));
  for (const auto& watch : watches) ASSERT_TRUE(watch->opened());
  const double open = probe_.device_bytes();
  EXPECT_GT(open, before + 4 * static_cast<double>(positions_.size()));  // they are accounted for
  EXPECT_EQ(probe_.metric("collided_watchers"), 4);
  EXPECT_EQ(probe_.streams(), 5);
  ASSERT_NO_FATAL_FAILURE(send_frames(4, 13));
  const double resident = probe_.resident_bytes();
  ASSERT_NO_FATAL_FAILURE(send_frames(14, 60));
  EXPECT_LT(probe_.resident_bytes(), resident + memory_limit(48));
  watches.clear();
  EXPECT_TRUE(probe_.becomes("collided_watchers", 0));
  EXPECT_TRUE(probe_.streams_become(1));
  EXPECT_LT(probe_.device_bytes(), open - 4 * static_cast<double>(positions_.size()));
}

}  // namespace
}  // namespace collided::test
