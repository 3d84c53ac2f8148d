// What a watcher may ask for. The refusals are tested against the daemon (tests/integration/watch).
#include "server/service/watch_options.hpp"

#include <gtest/gtest.h>

#include "tests/server/scenes/tiny_scene.hpp"
#include "tests/support/every_field.hpp"

namespace collided::server {
namespace {

TEST(WatchOptions, OfAnEmptyRequestAreEveryFrameAndNothingElse) {
  const auto options = parse_watch({}, tip_plan());
  EXPECT_EQ(options.frame_interval, 1u);
  EXPECT_EQ(options.period, Clock::duration{});
  EXPECT_EQ(options.max_contacts, 0u);
  EXPECT_TRUE(options.samples.of_mesh.empty());
}

TEST(WatchOptions, ARateIsAPeriod) {
  pb::WatchSceneRequest request;
  request.set_max_frames_per_second(8);
  EXPECT_EQ(parse_watch(request, tip_plan()).period, std::chrono::milliseconds(125));
}

TEST(WatchOptions, SamplesAreSceneWideAndHaveTheFirstVertexOfEachMesh) {
  pb::WatchSceneRequest request;
  request.add_position_meshes(1);
  request.add_position_meshes(0);
  request.set_vertex_stride(2);
  const auto options = parse_watch(request, tip_plan());
  EXPECT_EQ(options.samples.of_mesh, (std::vector<VertexSample>{{3, 2, 2}, {0, 2, 2}}));
}

TEST(WatchOptions, TheLeastStrideIsTheSmallestThatFits) {
  ScenePlan plan = tip_plan();
  for (const auto& [vertices, stride] :
       {std::pair{170'000u, 1u}, std::pair{175'000u, 2u}, std::pair{4'000'000u, 23u}}) {
    plan.engine.meshes[1].vertex_count = vertices;
    pb::WatchSceneRequest request;
    request.add_position_meshes(1);
    const auto options = parse_watch(request, plan);
    EXPECT_EQ(options.samples.stride, stride);
    EXPECT_LE(options.samples.of_mesh[0].count * 12, kMaxWatchedPositionBytes);
  }
}

TEST(WatchOptions, TheLargestMessageFitsADefaultClient) {
  ScenePlan plan = tip_plan();
  plan.fields = {test::kEveryField, true};
  plan.engine.kinds.triangle_triangle = true;
  plan.engine.meshes[1].vertex_count = 1'000'000;
  pb::WatchSceneRequest request;
  request.set_max_contacts_per_kind(kMaxWatchedContacts);
  request.add_position_meshes(1);
  const WatchOptions options = parse_watch(request, plan);
  EXPECT_LT(max_watch_message_bytes(options, options.samples, plan), uint64_t{4} << 20);
}

// Meshes that are gone have no positions, and those that have grown a stride at which they fit.
TEST(WatchOptions, SamplesFollowEdits) {
  ScenePlan plan = tip_plan();
  pb::WatchSceneRequest request;
  request.add_position_meshes(1);
  request.add_position_meshes(0);
  const WatchOptions options = parse_watch(request, plan);
  plan.engine.meshes[0].vertex_count = 0;
  plan.engine.meshes[1].vertex_count = 1'000'000;
  const VertexSamples samples = samples_after_edit(options, plan);
  EXPECT_EQ(options.samples.stride, 1u);
  EXPECT_EQ(samples.stride, 6u);
  EXPECT_EQ(samples.of_mesh, (std::vector<VertexSample>{{0, 6, 166'667}, {0, 6, 0}}));
}

}  // namespace
}  // namespace collided::server
