// Words of refusals: the names that clients set, and what helps.

#include <gtest/gtest.h>

#include "server/refusals/advice.hpp"
#include "server/refusals/field_path.hpp"

namespace collided::server {
namespace {

std::string frame_refusal(const std::string& field, const std::string& text) {
  return with_path(InvalidInput(field, text), frame_path).what();
}

TEST(Refusals, NameWhatClientsSetWhereverTheyNameIt) {
  EXPECT_EQ(frame_refusal("updates[1].start_transform", "updates[1].start_transform is given, but the scene is DCD"),
            "frame.updates[1].rigid.start_matrix is given, but the scene is DCD");
  EXPECT_EQ(frame_refusal("updates[0].transform",
                          "updates[0].transform turns mesh 0 by 4 radians: divide the step, or give start_transform"),
            "frame.updates[0].rigid.matrix turns mesh 0 by 4 radians: divide the step, or give rigid.start_matrix");
  EXPECT_EQ(frame_refusal("updates[0].start", "updates[0].start is given, but the mesh is rigid: start_transform says"),
            "frame.updates[0].start_positions is given, but the mesh is rigid: rigid.start_matrix says");
  EXPECT_EQ(frame_refusal("edit", "edit is given with start_fraction"), "frame.edit is given with from_last_fraction");
  EXPECT_EQ(frame_refusal("start_fraction", "start_fraction is 2"), "frame.from_last_fraction is 2");
  EXPECT_EQ(with_protocol_names("restart_transform, start_transforms"), "restart_transform, start_transforms");
}

BusyScene scene_of(Mode mode) {
  return {mode, [](uint32_t mesh) { return "mesh " + std::to_string(mesh); }};
}
bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Refusals, ATooLongFrameSaysWhatItFoundAndWhatHelps) {
  FrameProgress progress{.pairs = 5, .candidates = 60, .contacts = 7, .far_meshes = {}};
  progress.far_meshes = {{3, 0.5, 0.125}, {1, 0.25, 0.125}};
  const auto refusal =
      LimitExceeded::quota("client:one", "max_frame_seconds is 10, and frame 2 has run for 10.001 s", 0);
  const LimitExceeded advised = with_advice(refusal, progress, scene_of(Mode::kCcd));
  const std::string text = advised.what();
  EXPECT_EQ(advised.subject(), "client:one");
  EXPECT_EQ(text.find(refusal.what()), 0u);
  EXPECT_TRUE(has(text, "By then it had found 5 pairs of triangles, 60 candidates and 7 contacts")) << text;
  EXPECT_TRUE(has(text, ". In this step mesh 3 moves by 0.5 or more, 4 times its mean edge of 0.125, mesh 1 moves"))
      << text;
  EXPECT_TRUE(has(text, "several shorter ones")) << text;
  EXPECT_TRUE(has(text, "any_hit, earliest_only in CCD")) << text;
  EXPECT_TRUE(has(text, "--max-frame-seconds")) << text;
}

TEST(Refusals, EachLimitNamesTheOptionThatRaisesIt) {
  const FrameProgress progress{.pairs = 1, .far_meshes = {}};
  for (const auto& [limit, option] : {std::pair{"spec.memory_budget_bytes is 1 bytes", "--max-scene-mb"},
                                      {"max_device_bytes_per_client is 1 bytes", "--max-device-mb-per-client"},
                                      {"max_device_bytes is 1 bytes", "--max-device-mb"},
                                      {"max_device_bytes of cuda:0 is 1 bytes", "--max-device-mb"}}) {
    const std::string text = with_advice(LimitExceeded("f", limit), progress, scene_of(Mode::kDcd)).what();
    EXPECT_TRUE(text.ends_with(option) || has(text, std::string(option) + ",")) << text;
    EXPECT_FALSE(has(text, "earliest_only")) << text;
    EXPECT_FALSE(has(text, "moves by")) << text;
  }
}

}  // namespace
}  // namespace collided::server
