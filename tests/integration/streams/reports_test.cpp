// Options of one frame, its reports, and its warnings.
#include <gtest/gtest.h>

#include "tests/integration/support/daemon_process.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

class Reports : public testing::Test {
 protected:
  DaemonProcess daemon_;
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

// Two tips in one mesh: vertex 3 meets the floor at t = 1/2, vertex 6 at t = 1/4.
pb::CreateSceneRequest two_tips_request() {
  auto request = tip_request();
  auto* tips = request.mutable_spec()->mutable_meshes(1);
  tips->set_vertex_count(6);
  tips->set_triangles(pack<uint32_t>({0, 1, 2, 3, 4, 5}));
  return request;
}

std::string two_tips(double z0, double z1) {
  Points points = tip_points(z0);
  for (auto point : tip_points(z1)) points.push_back({point[0] + 0.5, point[1], point[2]});
  return pack_points(points, false);
}

pb::Frame two_tips_frame(uint64_t id, pb::Report report) {
  auto frame = id == 1 ? first_frame(2) : tip_frame(id, 2);
  frame.set_report(report);
  frame.mutable_updates(0)->set_start_positions(two_tips(1, 1));
  frame.mutable_updates(0)->set_positions(two_tips(-1, -3));
  return frame;
}

TEST_F(Reports, AnOverrideHoldsForItsFrameAlone) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  ASSERT_TRUE(stream.ask(first_frame(2)).done);
  auto frame = tip_frame(2, 2);
  frame.set_accuracy(pb::ACCURACY_CANDIDATES);
  const Answer candidates = stream.ask(frame);
  ASSERT_TRUE(candidates.done);
  EXPECT_GT(candidates.done->contact_count(), 1u);  // the edges of the tip that end at its corner, too
  for (const auto& chunk : candidates.chunks) EXPECT_TRUE(chunk.toi().empty() && chunk.flags().empty());
  expect_tip_contact(stream.ask(tip_frame(3, 2)), 2);
}

// A scene at CANDIDATES supports frames that request a higher level.
TEST_F(Reports, AnOverrideMayAskForMoreThanTheScene) {
  auto request = tip_request();
  request.mutable_spec()->set_accuracy(pb::ACCURACY_CANDIDATES);
  Stream stream(*stub_, make_scene(*stub_, request));
  auto frame = first_frame(2);
  frame.set_accuracy(pb::ACCURACY_CERTIFIED);
  expect_tip_contact(stream.ask(frame), 2);
  const Answer candidates = stream.ask(tip_frame(2, 2));
  ASSERT_TRUE(candidates.done);
  EXPECT_GT(candidates.done->contact_count(), 1u);
}

TEST_F(Reports, ReportsMayBeTheEarliestContactOrOnlyWhetherThereIsOne) {
  Stream stream(*stub_, make_scene(*stub_, two_tips_request()));
  const Answer all = stream.ask(two_tips_frame(1, pb::REPORT_UNSPECIFIED));
  ASSERT_TRUE(all.done);
  EXPECT_EQ(all.done->contact_count(), 2u);
  const Answer earliest = stream.ask(two_tips_frame(2, pb::REPORT_EARLIEST_ONLY));
  ASSERT_TRUE(earliest.done);
  EXPECT_EQ(earliest.done->contact_count(), 1u);
  EXPECT_EQ(earliest.done->earliest_toi(), all.done->earliest_toi());
  ASSERT_EQ(earliest.chunks.size(), 1u);
  EXPECT_EQ(earliest.chunks[0].elements(), pack<uint32_t>({6, 0}));
  EXPECT_EQ(earliest.chunks[0].toi(), pack<double>({all.done->earliest_toi()}));
  const Answer any_hit = stream.ask(two_tips_frame(3, pb::REPORT_ANY_HIT));
  ASSERT_TRUE(any_hit.done);
  EXPECT_TRUE(any_hit.done->any_contact());
  EXPECT_EQ(any_hit.done->contact_count(), 0u);
  EXPECT_EQ(any_hit.done->earliest_toi(), 1);
  EXPECT_TRUE(any_hit.chunks.empty());
  EXPECT_EQ(stream.ask(two_tips_frame(4, pb::REPORT_UNSPECIFIED)).done->contact_count(), 2u);
}

TEST_F(Reports, AFrameWithoutContactHasNoHit) {
  auto request = tip_request();
  request.mutable_spec()->set_report(pb::REPORT_ANY_HIT);
  Stream stream(*stub_, make_scene(*stub_, request));
  const Answer answer = stream.ask(first_frame(0.5));
  ASSERT_TRUE(answer.done);
  EXPECT_FALSE(answer.done->any_contact());
}

// Floats at 1e8 are 8 apart, as much as the triangles are large.
TEST_F(Reports, CoarsePositionsAreWarnedOf) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  auto far = first_frame(2);
  for (auto& update : *far.mutable_updates()) {
    Points points = update.mesh() == 0 ? floor_points() : tip_points(-1);
    for (auto& point : points) point[0] += 1e8;
    update.clear_start_positions();
    update.set_positions(pack_points(points, false));
  }
  const Answer answer = stream.ask(far);
  ASSERT_TRUE(answer.done) << (answer.error ? answer.error->message() : "ended");
  ASSERT_EQ(answer.done->metrics().warnings_size(), 1);
  EXPECT_EQ(answer.done->metrics().warnings(0), pb::FRAME_WARNING_INPUT_RESOLUTION);
}

TEST_F(Reports, ADeltaFinerThanThePositionsIsWarnedOfInItsFrameAlone) {
  Stream stream(*stub_, make_scene(*stub_, tip_request()));
  auto frame = first_frame(2);
  frame.set_delta(1e-12);
  EXPECT_EQ(stream.ask(frame).done->metrics().warnings_size(), 1);
  EXPECT_EQ(stream.ask(tip_frame(2, 2)).done->metrics().warnings_size(), 0);
}

}  // namespace
}  // namespace collided::test
