// Ends of a frame stream: closed, taken over, with its scene, with its device; and who may open the next.
#include <optional>

#include "tests/server/frames/session_test.hpp"

namespace collided::server {
namespace {

using Events = RecordingSink::Events;

using FrameSessionEnd = FrameSessionTest;

TEST_F(FrameSessionEnd, CloseDropsWhatWaitsAndFreesTheScene) {
  const auto stream = open_held(Delivery::kLossless);
  auto frame = tip_frame(1, 2);
  frame.input.slot = scene_->engine().take_slot();
  const std::weak_ptr<FrameSlot> slot = frame.input.slot;
  stream->submit(std::move(frame));
  stream->close();
  EXPECT_TRUE(slot.expired());
  EXPECT_TRUE(stream->is_closed());
  EXPECT_EQ(scene_->record().stream(), nullptr);
  stream->submit(tip_frame(2, 2));
  stream->hold(false);
  stream->announce_stop(1);
  stream->end(std::make_exception_ptr(Stopping()));
  scene_->worker().flush();
  EXPECT_LE(stream.sink->events().size(), 1u);  // the opening, if it was faster
  EXPECT_EQ(stream->waiting(), 0u);
  EXPECT_EQ(scene_->snapshot().last_frame_id, 0u);
}

TEST_F(FrameSessionEnd, CloseCancelsTheFrameThatWaitsForItsTurn) {
  TurnAccount other;
  std::optional turn = bench_.devices.turns({}).take(other);
  const auto stream = open();
  stream->submit(tip_frame(1, 2));
  stream->submit(tip_frame(2, 2));
  ASSERT_TRUE(wait_until([&] { return stream->waiting() == 1; }));  // the first is with the worker
  stream->close();
  scene_->worker().flush();  // though it never got a turn
  turn.reset();
  EXPECT_EQ(stream.sink->events(), Events{"opened after 0"});
  EXPECT_EQ(scene_->snapshot().last_frame_id, 0u);
}

TEST_F(FrameSessionEnd, ASecondStreamNeedsTheToken) {
  const auto first = open();
  EXPECT_THROW(open(), FailedPrecondition);
  EXPECT_THROW(open(Delivery::kLossless, "wrong"), PermissionDenied);
  EXPECT_THROW(open(Delivery::kLossless, token() + "0"), PermissionDenied);
  first->submit(tip_frame(1, 2));
  EXPECT_EQ(first.sink->wait_for(2), (Events{"opened after 0", "answered 1"}));
  first->close();
  EXPECT_THROW(open(Delivery::kLossless, "wrong"), PermissionDenied);  // even without another stream
  EXPECT_EQ(open().sink->wait_for(1), Events{"opened after 1"});
}

TEST_F(FrameSessionEnd, TheTokenTakesTheSceneOver) {
  const auto first = open();
  first->submit(tip_frame(1, 2));
  first.sink->wait_for(2);
  const auto second = open(Delivery::kLossless, token());
  EXPECT_TRUE(first->is_closed());
  EXPECT_EQ(first.sink->events().back(), "ended: TakenOver");
  EXPECT_EQ(scene_->record().stream(), second.session);
  first->submit(tip_frame(2, 2));
  first->close();  // does not end the other's stream
  second->submit(tip_frame(3, 2));
  EXPECT_EQ(second.sink->wait_for(2), (Events{"opened after 1", "answered 3"}));
  EXPECT_EQ(first.sink->events().size(), 3u);
}

TEST_F(FrameSessionEnd, OpenedIsToldOnceTheOldStreamsFrameIsOver) {
  TurnAccount other;
  std::optional turn = bench_.devices.turns({}).take(other);
  const auto first = open();
  first->submit(tip_frame(1, 2));
  first->submit(tip_frame(2, 2));
  ASSERT_TRUE(wait_until([&] { return first->waiting() == 1; }));
  const auto second = open(Delivery::kLossless, token());
  second->submit(tip_frame(1, 2));
  EXPECT_EQ(second.sink->wait_for(1), Events{"opened after 0"});  // though the old frame never got a turn
  turn.reset();
  EXPECT_EQ(second.sink->wait_for(2).back(), "answered 1");
  EXPECT_EQ(first.sink->events(), (Events{"opened after 0", "ended: TakenOver"}));
}

TEST_F(FrameSessionEnd, ADeletedSceneEndsItsStream) {
  const auto stream = open_held(Delivery::kLossless);
  stream.sink->wait_for(1);
  stream->submit(tip_frame(1, 2));
  bench_.scenes.remove(client(), scene_->id());
  EXPECT_EQ(stream.sink->events(), (Events{"opened after 0", "ended: NotFound"}));
  EXPECT_TRUE(stream->is_closed());
  EXPECT_THROW(open(), NotFound);
  EXPECT_THROW(open(Delivery::kLossless, token()), NotFound);
}

TEST_F(FrameSessionEnd, AFailedDeviceEndsTheStream) {
  const auto stream = open_held(Delivery::kLossless);
  stream->submit(refused(1, std::make_exception_ptr(DeviceError("is gone"))));
  stream->submit(tip_frame(2, 2));
  stream->hold(false);
  stream.sink->wait_for(2);
  scene_->worker().flush();
  EXPECT_EQ(stream.sink->events(), (Events{"opened after 0", "ended: DeviceError"}));
}

TEST_F(FrameSessionEnd, TellsThatTheDaemonStops) {
  const auto stream = open();
  stream.sink->wait_for(1);
  stream->announce_stop(2.5);
  stream->submit(tip_frame(1, 2));
  EXPECT_EQ(stream.sink->wait_for(3), (Events{"opened after 0", "draining 2.5", "answered 1"}));
}

TEST_F(FrameSessionEnd, IsIdleWhileNoFrameIsInHand) {
  using std::chrono::seconds;
  const auto stream = open_held(Delivery::kLossless);
  stream->submit(tip_frame(1, 2));
  clock_.move(seconds(200));
  EXPECT_EQ(stream->idle_seconds(), 200);  // the client takes nothing
  stream->hold(true);
  EXPECT_EQ(stream->idle_seconds(), 0);  // it took something, but not enough
  stream->hold(false);
  stream.sink->wait_for(2);
  scene_->worker().flush();
  EXPECT_EQ(stream->idle_seconds(), 0);
  clock_.move(seconds(2));
  EXPECT_EQ(stream->idle_seconds(), 2);
}

}  // namespace
}  // namespace collided::server
