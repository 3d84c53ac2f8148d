// One stream of frames to one scene: order of the answers, delivery policy, holding.
#include "server/frames/session.hpp"

#include "tests/server/frames/session_test.hpp"

namespace collided::server {
namespace {

using Events = RecordingSink::Events;

TEST_F(FrameSessionTest, AnswersInTheOrderOfTheFrames) {
  const auto stream = open();
  for (uint64_t id = 1; id <= 20; ++id) stream->submit(tip_frame(id, 2));
  Events expected = {"opened after 0"};
  for (uint64_t id = 1; id <= 20; ++id) expected.push_back("answered " + std::to_string(id));
  EXPECT_EQ(stream.sink->wait_for(expected.size()), expected);
  EXPECT_EQ(scene_->snapshot().last_frame_id, 20u);
}

TEST_F(FrameSessionTest, RefusalsComeInTheirTurnAndTheStreamGoesOn) {
  const auto stream = open_held(Delivery::kLossless);
  stream->submit(tip_frame(1, 2));
  stream->submit(bad(2));
  stream->submit(tip_frame(1, 2));  // an id that was used
  stream->submit(tip_frame(3, 2));
  stream->hold(false);
  EXPECT_EQ(stream.sink->wait_for(5), (Events{"opened after 0", "answered 1", "refused 2: INVALID_ARGUMENT",
                                              "refused 1: FAILED_PRECONDITION", "answered 3"}));
  EXPECT_EQ(bench_.observer.refusals, 2);
}

TEST_F(FrameSessionTest, LatestWinsSkipsWhatALaterFrameCovers) {
  const auto stream = open_held(Delivery::kLatestWins);
  for (uint64_t id = 1; id <= 4; ++id) stream->submit(tip_frame(id, 2));
  EXPECT_EQ(stream->waiting(), 4u);
  stream->hold(false);
  EXPECT_EQ(stream.sink->wait_for(5), (Events{"opened after 0", "skipped 1", "skipped 2", "skipped 3", "answered 4"}));
  EXPECT_EQ(bench_.observer.count_of(CounterId::kSkippedFrames), 3);
}

TEST_F(FrameSessionTest, LosslessSkipsNothing) {
  const auto stream = open_held(Delivery::kLossless);
  for (uint64_t id = 1; id <= 3; ++id) stream->submit(tip_frame(id, 2));
  stream->hold(false);
  EXPECT_EQ(stream.sink->wait_for(4), (Events{"opened after 0", "answered 1", "answered 2", "answered 3"}));
}

TEST_F(FrameSessionTest, LatestWinsLosesNothingThatAFrameAloneBrings) {
  const auto stream = open_held(Delivery::kLatestWins);
  stream->submit(tip_frame(1, 2));
  stream->submit(partial(2));  // has no floor, unlike frame 1
  stream->submit(sparse(3));   // lacks two corners, unlike frame 2
  stream->submit(sparse(4));
  stream->hold(false);
  EXPECT_EQ(stream.sink->wait_for(5),
            (Events{"opened after 0", "answered 1", "answered 2", "answered 3", "answered 4"}));
  stream->hold(true);
  stream->submit(sparse(5));
  stream->submit(partial(6));
  stream->submit(partial(7));
  stream->hold(false);
  const auto events = stream.sink->wait_for(8);
  EXPECT_EQ(Events(events.begin() + 5, events.end()), (Events{"skipped 5", "skipped 6", "answered 7"}));
}

// Frame 4 covers frame 2, but not frame 3, which is answered as if nothing had been skipped.
TEST_F(FrameSessionTest, LatestWinsLeavesWhatAFrameInBetweenBuildsOn) {
  const auto stream = open_held(Delivery::kLatestWins);
  stream->submit(tip_frame(1, 2));
  stream->submit(partial(2));
  stream->submit(floor(3));
  stream->submit(partial(4));
  stream->submit(partial(5));
  stream->hold(false);
  EXPECT_EQ(stream.sink->wait_for(6),
            (Events{"opened after 0", "answered 1", "answered 2", "answered 3", "skipped 4", "answered 5"}));
}

// Those of other worlds build on nothing of these.
TEST_F(FrameSessionTest, LatestWinsSkipsPastFramesOfOtherWorlds) {
  const auto stream = open_held(Delivery::kLatestWins);
  const auto submit = [&](PendingFrame frame, std::vector<uint32_t> worlds) {
    frame.worlds = std::move(worlds);
    const std::weak_ptr<const void> memory = frame.memory;
    stream->submit(std::move(frame));
    return memory;
  };
  const auto first = submit(partial(1), {0, 2}), second = submit(floor(2), {1}), third = submit(partial(3), {0, 2});
  EXPECT_TRUE(first.expired());
  EXPECT_FALSE(second.expired());
  submit(floor(4), {2, 3});
  submit(partial(5), {0, 2});
  EXPECT_FALSE(third.expired());  // frame 4 builds on it
  stream->close();
}

TEST_F(FrameSessionTest, LatestWinsNeitherSkipsRefusalsNorForThem) {
  const auto stream = open_held(Delivery::kLatestWins);
  stream->submit(bad(1));
  stream->submit(tip_frame(2, 2));
  stream->submit(bad(3));
  stream->hold(false);
  EXPECT_EQ(stream.sink->wait_for(4), (Events{"opened after 0", "refused 1: INVALID_ARGUMENT", "answered 2",  //
                                              "refused 3: INVALID_ARGUMENT"}));
}

TEST_F(FrameSessionTest, ASkippedFrameLetsGoOfItsMemoryAtOnce) {
  const auto stream = open_held(Delivery::kLatestWins);
  auto first = tip_frame(1, 2);
  first.input.slot = scene_->engine().take_slot();
  const std::weak_ptr<const void> memory = first.memory;
  const std::weak_ptr<FrameSlot> slot = first.input.slot;
  stream->submit(std::move(first));
  EXPECT_FALSE(memory.expired() || slot.expired());
  stream->submit(tip_frame(2, 2));
  EXPECT_TRUE(memory.expired() && slot.expired());
}

TEST_F(FrameSessionTest, HeldFramesWait) {
  const auto stream = open();
  stream->submit(tip_frame(1, 2));
  stream.sink->wait_for(2);
  stream->hold(true);
  stream->submit(tip_frame(2, 2));
  stream->submit(tip_frame(3, 2));
  scene_->worker().flush();
  EXPECT_EQ(stream.sink->events().size(), 2u);
  EXPECT_EQ(stream->waiting(), 2u);
  stream->hold(false);
  EXPECT_EQ(stream.sink->wait_for(4).back(), "answered 3");
  EXPECT_EQ(stream->waiting(), 0u);
}

}  // namespace
}  // namespace collided::server
