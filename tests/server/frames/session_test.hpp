#pragma once
// A scene, streams to it, and frames of each kind.

#include <gtest/gtest.h>

#include "tests/server/frames/recording_sink.hpp"
#include "tests/server/hand_clock.hpp"
#include "tests/server/scenes/tiny_scene.hpp"

namespace collided::server {

class FrameSessionTest : public testing::Test {
 protected:
  struct Stream {
    std::shared_ptr<RecordingSink> sink;
    std::shared_ptr<FrameSession> session;
    FrameSession* operator->() const { return session.get(); }
  };

  Stream open(Delivery delivery = Delivery::kLossless, const std::string& token = "") {
    auto sink = std::make_shared<RecordingSink>();
    auto session = FrameSession::open(scene_, token, delivery, sink);
    return {std::move(sink), std::move(session)};
  }
  // Frames wait until hold(false), so that the waiting ones are known.
  Stream open_held(Delivery delivery) {
    auto stream = open(delivery);
    stream->hold(true);
    return stream;
  }
  const std::string& token() const { return scene_->identity().resume_token; }

  static PendingFrame refused(uint64_t id, std::exception_ptr why) {
    PendingFrame frame = tip_frame(id, 2);
    frame.refusal = std::move(why);
    return frame;
  }
  static PendingFrame bad(uint64_t id) { return refused(id, std::make_exception_ptr(InvalidInput("field", "is bad"))); }
  // Updates the tip only.
  static PendingFrame partial(uint64_t id) {
    PendingFrame frame = tip_frame(id, 2);
    frame.input.updates.erase(frame.input.updates.begin());
    frame.meshes = {{1, true}};
    return frame;
  }
  // Updates the floor only.
  static PendingFrame floor(uint64_t id) {
    PendingFrame frame = tip_frame(id, 2);
    frame.input.updates.erase(frame.input.updates.begin() + 1);
    frame.meshes = {{0, true}};
    return frame;
  }
  // Updates only the lowest corner of the tip.
  static PendingFrame sparse(uint64_t id) {
    static constexpr uint32_t kCorner = 0;
    PendingFrame frame = partial(id);
    MeshPositions& tip = frame.input.updates[0];
    tip = {1, tip.start.first(12), tip.end.first(12), true, std::as_bytes(std::span(&kCorner, 1))};
    frame.meshes = {{1, false}};
    return frame;
  }

  const HandClock clock_;
  SceneBench bench_{64, Turns::Options{.concurrent = 1, .now = clock_.now()}};
  SceneUse scene_ = bench_.add();
};

}  // namespace collided::server
