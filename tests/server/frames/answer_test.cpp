// The end of a frame's answer.
#include "server/frames/answer.hpp"

#include <gtest/gtest.h>

#include "tests/server/convert/scene_request.hpp"

namespace collided::server {
namespace {

TEST(FrameAnswer, DoneTellsWhatTheFrameCost) {
  AnsweredFrame frame;
  FrameResult& result = frame.result;
  result.replays = 1;
  result.allocations = 2;
  result.graph_launches = 3;
  result.step_milliseconds = 0.25;
  result.broad_phase = {Engine::kOctree, EngineReason::kFaster, 0.5, 0.75};
  FrameCost& cost = frame.cost;
  cost.queue_milliseconds = 1;
  cost.decode_milliseconds = 2;
  cost.engine_milliseconds = 3;
  cost.encode_milliseconds = 4;
  cost.total_milliseconds = 10;
  cost.device_bytes = 11;
  cost.bytes_in = 12;
  cost.bytes_out = 13;
  for (const auto& [message, engine] : kEngines) {
    result.broad_phase.engine = engine;
    const pb::FrameDone done = done_message(frame);
    EXPECT_EQ(done.metrics().queue_milliseconds(), 1);
    EXPECT_EQ(done.metrics().decode_milliseconds(), 2);
    EXPECT_EQ(done.metrics().engine_milliseconds(), 3);
    EXPECT_EQ(done.metrics().encode_milliseconds(), 4);
    EXPECT_EQ(done.metrics().total_milliseconds(), 10);
    EXPECT_EQ(done.metrics().device_bytes(), 11u);
    EXPECT_EQ(done.metrics().bytes_in(), 12u);
    EXPECT_EQ(done.metrics().bytes_out(), 13u);
    EXPECT_EQ(done.metrics().replays(), 1u);
    EXPECT_EQ(done.metrics().allocations(), 2u);
    EXPECT_EQ(done.metrics().graph_launches(), 3u);
    EXPECT_EQ(done.metrics().step_milliseconds(), 0.25);
    EXPECT_EQ(done.metrics().broad_phase_engine(), message);
    EXPECT_EQ(done.metrics().broad_phase_reason(), pb::BROAD_PHASE_REASON_FASTER);
    EXPECT_EQ(done.metrics().octree_milliseconds(), 0.5);
    EXPECT_EQ(done.metrics().lbvh_milliseconds(), 0.75);
  }
}

TEST(FrameAnswer, DoneTellsOfListsOfNeighbours) {
  AnsweredFrame frame;
  EXPECT_EQ(done_message(frame).metrics().list_use(), pb::LIST_USE_NONE);
  EXPECT_EQ(done_message(frame).metrics().reuse_reason(), pb::REUSE_REASON_REQUESTED);
  frame.result.reuse = {ListUse::kReused, ReuseReason::kFaster, 0.125, 3, 0.25, 0.5};
  const pb::FrameMetrics metrics = done_message(frame).metrics();
  EXPECT_EQ(metrics.list_use(), pb::LIST_USE_REUSED);
  EXPECT_EQ(metrics.reuse_reason(), pb::REUSE_REASON_FASTER);
  EXPECT_EQ(metrics.list_margin(), 0.125);
  EXPECT_EQ(metrics.list_frames(), 3u);
  EXPECT_EQ(metrics.list_milliseconds(), 0.25);
  EXPECT_EQ(metrics.search_milliseconds(), 0.5);
}

TEST(FrameAnswer, DoneTellsTotalsCountsAndWarnings) {
  AnsweredFrame frame;
  FrameResult& result = frame.result;
  result.vertex_triangle.elements = {{3, 0}};
  result.triangle_triangle.elements = {{0, 1}, {0, 2}};
  result.counts.contacts.triangle_triangle = 2;
  result.counts.survivors.vertex_triangle = 3;
  result.counts.survivors.edge_edge = 4;
  result.counts.exact_decisions = 5;
  result.earliest_toi = 0.5;
  result.any_contact = true;
  pb::FrameDone done = done_message(frame);
  EXPECT_EQ(done.contact_count(), 3u);
  EXPECT_TRUE(done.any_contact());
  EXPECT_EQ(done.earliest_toi(), 0.5);
  EXPECT_EQ(done.metrics().counts().contacts_triangle_triangle(), 2u);
  EXPECT_EQ(done.metrics().counts().survivors_vertex_triangle(), 3u);
  EXPECT_EQ(done.metrics().counts().survivors_edge_edge(), 4u);
  EXPECT_EQ(done.metrics().counts().exact_decisions(), 5u);
  EXPECT_TRUE(done.metrics().warnings().empty());
  result.input_resolution = true;
  done = done_message(frame);
  ASSERT_EQ(done.metrics().warnings_size(), 1);
  EXPECT_EQ(done.metrics().warnings(0), pb::FRAME_WARNING_INPUT_RESOLUTION);
}

// Watchers are shown it, and what they are shown is bounded.
TEST(FrameAnswer, DoneHasHowFarTheFrameWentWithoutEachShortenedWayLimitAndPair) {
  AnsweredFrame frame;
  frame.result.advanced = 0.25, frame.result.way = 0.5;
  frame.result.shortened = {{1, 4}, {0.25, 0.75}};
  frame.result.limits.vertex_triangle.elements = {{3, 0}};
  frame.result.pair_states = {{.first = 0, .second = 1}};
  const pb::FrameDone done = done_message(frame);
  EXPECT_EQ(done.advanced(), 0.25);
  EXPECT_EQ(done.way(), 0.5);
  EXPECT_FALSE(done.has_shortened());
  EXPECT_FALSE(done.has_pairs());
  EXPECT_EQ(done.limits_size(), 0);
}

}  // namespace
}  // namespace collided::server
