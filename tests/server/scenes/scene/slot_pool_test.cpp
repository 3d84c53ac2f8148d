// Slots are reused, end with their pool, and may outlive it.
#include "server/scenes/scene/slot_pool.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <thread>

#include "server/devices/device_bytes.hpp"
#include "tests/server/scenes/tiny_scene.hpp"

namespace collided::server {
namespace {

class SlotPoolTest : public testing::Test {
 protected:
  std::shared_ptr<Detector> make_detector() const {
    SceneSpec spec = tip_plan().engine;
    spec.memory_quota = held_;
    return Detector::create(std::move(spec));
  }

  const std::shared_ptr<DeviceBytes> held_ = std::make_shared<DeviceBytes>("daemon", "limit", uint64_t{1} << 30);
  std::shared_ptr<Detector> detector_ = make_detector();
  std::shared_ptr<SlotPool> pool_ = std::make_shared<SlotPool>(detector_);
};

TEST_F(SlotPoolTest, ASlotThatIsBackIsUsedAgain) {
  auto slot = pool_->take();
  slot->room(uint64_t{1} << 20);
  const FrameSlot* first = slot.get();
  const uint64_t before = held_->held();
  slot.reset();
  EXPECT_EQ(held_->held(), before);
  EXPECT_EQ(pool_->take().get(), first);
  EXPECT_EQ(held_->held(), before);
}

TEST_F(SlotPoolTest, SlotsInUseAreNotSharedAndAllComeBack) {
  auto a = pool_->take(), b = pool_->take();
  const FrameSlot *first = a.get(), *second = b.get();
  EXPECT_NE(first, second);
  a.reset();
  b.reset();
  const auto c = pool_->take(), d = pool_->take();
  EXPECT_TRUE((c.get() == first && d.get() == second) || (c.get() == second && d.get() == first));
}

TEST_F(SlotPoolTest, ASlotThatIsUsedAgainBringsNothingOfTheFrameBefore) {
  auto frame = tip_frame(1, 2);
  FrameInput input;
  input.slot = pool_->take();
  input.slot->send(frame.input.updates);
  detector_->detect(input);
  input.slot.reset();
  input.slot = pool_->take();
  frame.input.updates[1].end = frame.input.updates[1].end.first(12);
  EXPECT_THROW(input.slot->send(frame.input.updates), InvalidInput);
  EXPECT_THROW(detector_->detect(input), InvalidInput);  // not the positions that it had
}

TEST_F(SlotPoolTest, CloseFreesWhatIsFreeAndTakesNothingBack) {
  auto free = pool_->take(), used = pool_->take();
  const uint64_t before = held_->held();
  free->room(uint64_t{1} << 20);
  used->room(uint64_t{1} << 20);
  EXPECT_GE(held_->held(), before + (uint64_t{2} << 20));
  free.reset();
  EXPECT_GE(held_->held(), before + (uint64_t{2} << 20));  // kept for the next frame
  pool_->close();
  EXPECT_LT(held_->held(), before + (uint64_t{2} << 20));
  EXPECT_EQ(pool_->take(), nullptr);
  used.reset();
  detector_.reset();
  EXPECT_EQ(held_->held(), 0u);
  pool_->close();
}

TEST_F(SlotPoolTest, ASlotMayOutliveItsPoolAndItsScene) {
  const auto slot = pool_->take();
  pool_->close();
  pool_.reset();
  detector_.reset();
  const auto room = slot->room(1000);
  ASSERT_GE(room.size(), 1000u);
  std::memset(room.data(), 1, room.size());
  const auto frame = tip_frame(1, 2);
  EXPECT_NO_THROW(slot->send(frame.input.updates));
}

TEST_F(SlotPoolTest, ManyThreadsTakeAndLetGoWhileItCloses) {
  detector_.reset();  // only the pool keeps it alive
  std::atomic<int> taken = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      while (const auto slot = pool_->take()) {
        slot->room(64);
        ++taken;
      }
    });
  while (taken < 100) std::this_thread::yield();
  pool_->close();
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(held_->held(), 0u);
}

}  // namespace
}  // namespace collided::server
