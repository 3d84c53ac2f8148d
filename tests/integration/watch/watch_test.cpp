// What a watcher is shown of the frames that others send.
#include "tests/integration/support/watch.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/layers.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

/// Positions of every `stride`-th vertex.
std::string thinned(const std::string& positions, size_t stride, size_t vertex_bytes = 3 * sizeof(float)) {
  std::string out;
  for (size_t at = 0; at < positions.size(); at += stride * vertex_bytes) out += positions.substr(at, vertex_bytes);
  return out;
}

class WatchScene : public testing::Test {
 protected:
  DaemonProcess daemon_;
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

void expect_same_totals(const pb::FrameDone& shown, const pb::FrameDone& answered) {
  EXPECT_EQ(shown.contact_count(), answered.contact_count());
  EXPECT_EQ(shown.any_contact(), answered.any_contact());
  EXPECT_EQ(shown.earliest_toi(), answered.earliest_toi());
  EXPECT_EQ(shown.metrics().counts().SerializeAsString(), answered.metrics().counts().SerializeAsString());
  EXPECT_EQ(shown.metrics().stages_size(), answered.metrics().stages_size());
  EXPECT_GT(shown.metrics().total_milliseconds(), 0);
}

TEST_F(WatchScene, EveryWatcherSeesEveryFrameInOrder) {
  const auto id = make_scene(*stub_, tip_request());
  Watch first(*stub_, watch_request(id)), second(*stub_, watch_request(id));
  ASSERT_TRUE(first.opened() && second.opened());
  EXPECT_EQ(first.opened()->scene().scene_id(), id);
  EXPECT_EQ(first.opened()->scene().spec().meshes(1).vertex_count(), 3u);
  EXPECT_EQ(first.opened()->vertex_stride(), 0u);
  Stream stream(*stub_, id);
  for (uint64_t frame = 1; frame <= 5; ++frame) {
    const double depth = frame % 2 ? 2 : 0.5;
    const auto answer = stream.ask(frame == 1 ? first_frame(depth) : tip_frame(frame, depth));
    ASSERT_TRUE(answer.done);
    for (Watch* watch : {&first, &second}) {
      const auto shown = watch->next();
      ASSERT_TRUE(shown && shown->has_done());
      EXPECT_EQ(shown->frame_id(), frame);
      EXPECT_EQ(shown->skipped_frames(), 0u);
      EXPECT_EQ(shown->omitted_contacts(), shown->done().contact_count());
      EXPECT_EQ(shown->done().contacts_size(), 0);
      expect_same_totals(shown->done(), *answer.done);
    }
  }
}

TEST_F(WatchScene, FramesOfDetectFrameAreShownAndRefusedOnesAreNot) {
  const auto id = make_scene(*stub_, tip_request());
  Watch watch(*stub_, watch_request(id, [](auto& request) { request.set_max_contacts_per_kind(10); }));
  ASSERT_TRUE(detect(*stub_, id, first_frame(2)).ok());
  ASSERT_FALSE(detect(*stub_, id, tip_frame(1, 2)).ok());  // a stale id
  ASSERT_TRUE(detect(*stub_, id, tip_frame(7, 4)).ok());
  for (const auto& [frame, depth] : {std::pair{1u, 2.0}, std::pair{7u, 4.0}}) {
    auto shown = watch.next();
    ASSERT_TRUE(shown);
    EXPECT_LE(shown->skipped_frames(), 1u);
    if (shown->skipped_frames() > 0) {  // the second frame came before the first was sent
      EXPECT_EQ(shown->frame_id(), 7u);
      break;
    }
    EXPECT_EQ(shown->frame_id(), frame);
    const auto& chunks = shown->done().contacts();
    expect_tip_contact({chunks.begin(), chunks.end()}, shown->done(), depth);
  }
}

TEST_F(WatchScene, AWatchBeginsWithTheNextFrame) {
  const auto id = make_scene(*stub_, tip_request());
  ASSERT_TRUE(detect(*stub_, id, first_frame(2)).ok());
  Watch watch(*stub_, watch_request(id));
  ASSERT_TRUE(watch.opened());
  EXPECT_EQ(watch.opened()->scene().last_frame_id(), 1u);
  ASSERT_TRUE(detect(*stub_, id, tip_frame(2, 2)).ok());
  const auto shown = watch.next();
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->frame_id(), 2u);
  EXPECT_EQ(shown->skipped_frames(), 0u);
}

TEST_F(WatchScene, EachWatcherSeesTheFirstContactsThatItAsksForAndHowManyAreLeftOut) {
  constexpr uint32_t kSide = 10;
  const auto id = make_scene(*stub_, layers_request(kSide));
  const auto asking = [&](uint32_t contacts) {
    return watch_request(id, [=](auto& request) { request.set_max_contacts_per_kind(contacts); });
  };
  Watch few(*stub_, asking(5)), all(*stub_, asking(8192));
  pb::DetectFrameResponse answer;
  ASSERT_TRUE(detect(*stub_, id, layers_frame(1, pack_points(layer_points(kSide))), &answer).ok());
  ASSERT_GT(answer.done().contact_count(), 100u);
  const auto shown_all = all.next(), shown_few = few.next();
  ASSERT_TRUE(shown_all && shown_few);
  EXPECT_EQ(shown_all->omitted_contacts(), 0u);
  ASSERT_EQ(shown_all->done().contacts_size(), answer.contacts_size());
  ASSERT_EQ(shown_few->done().contacts_size(), answer.contacts_size());
  uint64_t shown = 0;
  for (int i = 0; i < answer.contacts_size(); ++i) {
    const auto &whole = answer.contacts(i), &part = shown_few->done().contacts(i);
    EXPECT_TRUE(shown_all->done().contacts(i).SerializeAsString() == whole.SerializeAsString());
    EXPECT_EQ(part.kind(), whole.kind());
    EXPECT_EQ(part.count(), 5u);
    EXPECT_TRUE(part.elements() == whole.elements().substr(0, 5 * 2 * sizeof(uint32_t)));
    EXPECT_TRUE(part.stencils() == whole.stencils().substr(0, 5 * 4 * sizeof(uint32_t)));
    EXPECT_TRUE(part.distance() == whole.distance().substr(0, 5 * sizeof(double)));
    EXPECT_TRUE(part.flags() == whole.flags().substr(0, 5));
    shown += part.count();
  }
  EXPECT_EQ(shown_few->done().contact_count(), answer.done().contact_count());
  EXPECT_EQ(shown_few->omitted_contacts(), answer.done().contact_count() - shown);
}

TEST_F(WatchScene, PositionsAreThoseOfEveryStrideThVertexAfterTheFrame) {
  constexpr uint32_t kSide = 20;
  const auto id = make_scene(*stub_, layers_request(kSide));
  const auto asking = [&](uint32_t stride) {
    return watch_request(id, [=](auto& request) {
      request.add_position_meshes(0);
      request.set_vertex_stride(stride);
    });
  };
  Watch whole(*stub_, asking(0)), some(*stub_, asking(7)), one(*stub_, asking(1'000'000));
  EXPECT_EQ(whole.opened()->vertex_stride(), 1u);  // all of them fit
  for (uint64_t frame = 1; frame <= 3; ++frame) {
    const std::string positions = pack_points(layer_points(kSide, kLayerGap * static_cast<double>(frame)));
    ASSERT_TRUE(detect(*stub_, id, layers_frame(frame, positions)).ok());
    auto broken = layers_frame(frame + 1, positions);
    broken.mutable_updates(0)->mutable_positions()->replace(0, 4, "\xff\xff\xff\xff");  // NaN
    ASSERT_FALSE(detect(*stub_, id, broken).ok());
    for (const auto& [watch, stride] : {std::pair{&whole, 1u}, std::pair{&some, 7u}, std::pair{&one, 1'000'000u}}) {
      const auto shown = watch->next();
      ASSERT_TRUE(shown);
      ASSERT_EQ(shown->positions_size(), 1);
      EXPECT_EQ(shown->positions(0).mesh(), 0u);
      EXPECT_EQ(shown->positions(0).vertex_stride(), stride);
      EXPECT_TRUE(shown->positions(0).positions() == thinned(positions, stride));
    }
  }
}

TEST_F(WatchScene, PositionsOfSeveralMeshesComeInTheOrderAskedForAndTheSceneFormat) {
  const auto id = make_scene(*stub_, tip_request(true));
  Watch watch(*stub_, watch_request(id, [](auto& request) {
    request.add_position_meshes(1);
    request.add_position_meshes(0);
    request.set_vertex_stride(2);
  }));
  for (uint64_t frame = 1; frame <= 2; ++frame) {  // only the first one brings the floor
    const double depth = 1 + static_cast<double>(frame);
    ASSERT_TRUE(detect(*stub_, id, frame == 1 ? first_frame(depth, true) : tip_frame(frame, depth, true)).ok());
    const auto shown = watch.next();
    ASSERT_TRUE(shown);
    ASSERT_EQ(shown->positions_size(), 2);
    EXPECT_EQ(shown->positions(0).mesh(), 1u);
    EXPECT_EQ(shown->positions(0).positions(), thinned(pack_points(tip_points(1 - depth), true), 2, 24));
    EXPECT_EQ(shown->positions(1).mesh(), 0u);
    EXPECT_EQ(shown->positions(1).positions(), thinned(pack_points(floor_points(), true), 2, 24));
  }
}

TEST_F(WatchScene, AnIntervalShowsEverySoManyFrames) {
  const auto id = make_scene(*stub_, tip_request());
  Watch watch(*stub_, watch_request(id, [](auto& request) { request.set_frame_interval(3); }));
  Stream stream(*stub_, id);
  for (uint64_t frame = 1; frame <= 9; ++frame) {
    ASSERT_TRUE(stream.ask(frame == 1 ? first_frame(2) : tip_frame(frame, 2)).done);
    if (frame % 3) continue;
    const auto shown = watch.next();
    ASSERT_TRUE(shown);
    EXPECT_EQ(shown->frame_id(), frame);
    EXPECT_EQ(shown->skipped_frames(), 2u);
  }
}

// However many it misses, it sees the last one.
TEST_F(WatchScene, ARateLimitsTheMessagesAndTheLatestFrameIsShown) {
  constexpr uint64_t kFrames = 40;
  const auto id = make_scene(*stub_, tip_request());
  Watch watch(*stub_, watch_request(id, [](auto& request) { request.set_max_frames_per_second(10); }));
  Watch once(*stub_, watch_request(id, [](auto& request) { request.set_max_frames_per_second(0.001); }));
  Stream stream(*stub_, id);
  for (uint64_t frame = 1; frame <= kFrames; ++frame)
    ASSERT_TRUE(stream.ask(frame == 1 ? first_frame(2) : tip_frame(frame, 2)).done);
  uint64_t last = 0;
  while (last < kFrames) {
    const auto shown = watch.next();
    ASSERT_TRUE(shown);
    EXPECT_EQ(shown->frame_id(), last + shown->skipped_frames() + 1);
    last = shown->frame_id();
  }
  ASSERT_TRUE(once.next());
  ASSERT_TRUE(delete_scene(*stub_, id).ok());
  EXPECT_FALSE(once.next());  // not even within the minutes that this takes otherwise
}

}  // namespace
}  // namespace collided::test
